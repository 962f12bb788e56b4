#include "replay/live/live_view.h"

#include <algorithm>
#include <fmt/format.h>

namespace risorius {
namespace {

constexpr std::size_t kStrongestAus = 5;
constexpr int kLooksBeforeSilence = 10;

/// "AU12L ####....  0.48" for the strongest AUs, side by side.
std::string strongest_aus(const std::map<std::string, double>& aus) {
  std::vector<std::pair<std::string, double>> sorted(aus.begin(), aus.end());
  std::ranges::stable_sort(sorted, std::greater<>(), [](const auto& au) { return au.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min(kStrongestAus, sorted.size()); ++i) {
    const auto filled = static_cast<std::size_t>(std::clamp(sorted[i].second / 1.2, 0.0, 1.0) * 8 + 0.5);
    text += fmt::format("{}{:<6}{}{} {:.2f}", i == 0 ? "" : "  ", sorted[i].first, std::string(filled, '#'),
                        std::string(8 - filled, '.'), sorted[i].second);
  }
  return text;
}

std::uint64_t number_at(const nlohmann::json& json, const char* path) {
  const nlohmann::json::json_pointer pointer(path);
  return json.contains(pointer) ? json.at(pointer).get<std::uint64_t>() : 0;
}

}  // namespace

void LiveView::update(const std::string& topic, const nlohmann::json& message) {
  if (topic == "status") {
    status_ = message;
    // Those too of which nothing has come yet.
    if (message.contains("streams")) {
      for (const auto& [name, stream] : message.at("streams").items()) streams_[name];
    }
    return;
  }
  Stream& stream = streams_[message.at("stream").get<std::string>()];
  if (topic == "au") {
    ++au_messages_;
    ++stream.frames;
    stream.latest_latency_ns =
        message.at("publish_time_ns").get<std::int64_t>() - message.at("receive_time_ns").get<std::int64_t>();
    stream.status = message.at("status").get<std::string>();
    stream.au.clear();
    for (const auto& [name, value] : message.at("au").items())
      if (value.is_number()) stream.au[name] = value.get<double>();
  } else if (topic == "markers") {
    const auto states = message.at("states").get<std::string>();
    stream.samples += states.size();
    stream.filled += static_cast<std::uint64_t>(std::ranges::count(states, 'f'));
  }
}

std::vector<std::string> LiveView::lines(std::int64_t now_ns) {
  std::vector<std::string> lines;
  for (auto& [name, stream] : streams_) {
    if (stream.last_look_ns > 0 && now_ns > stream.last_look_ns) {
      stream.rate_hz = static_cast<double>(stream.frames - stream.frames_at_last_look) * 1e9 /
                       static_cast<double>(now_ns - stream.last_look_ns);
    }
    stream.looks_without_frames = stream.frames == stream.frames_at_last_look ? stream.looks_without_frames + 1 : 0;
    const bool silent = stream.frames == 0 || stream.looks_without_frames >= kLooksBeforeSilence;
    stream.last_look_ns = now_ns;
    stream.frames_at_last_look = stream.frames;
    const std::string base = "/streams/" + name;
    const std::uint64_t lost = number_at(status_, (base + "/frames/lost").c_str());
    const std::uint64_t dropped = number_at(status_, (base + "/admission/dropped").c_str());
    const double filled =
        stream.samples > 0 ? 100 * static_cast<double>(stream.filled) / static_cast<double>(stream.samples) : 0;
    const auto pointer = nlohmann::json::json_pointer(base);
    const auto problem = status_.contains(pointer) ? status_.at(pointer).value("rig_problem", "") : std::string();
    const auto state = status_.contains(pointer) ? status_.at(pointer).value("state", "") : std::string();
    lines.push_back(fmt::format("{:<12} {:7.1f} Hz | latency {:6.2f} ms | lost {} dropped {} | filled {:.2f} % | {}",
                                name, stream.rate_hz, static_cast<double>(stream.latest_latency_ns) * 1e-6, lost,
                                dropped, filled, silent ? state : stream.status));
    // What came last is not what the face does now.
    if (silent) {
      lines.emplace_back("  nothing comes");
    } else {
      lines.push_back(
          "  " + (stream.au.empty() ? "no AUs" + (problem.empty() ? "" : ": " + problem) : strongest_aus(stream.au)));
    }
  }
  return lines;
}

}  // namespace risorius
