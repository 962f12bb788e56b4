// What the control messages do (daemon/README.md, "Control in"). On the I/O thread.
#include <boost/asio/post.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "daemon/live_target_request.h"
#include "daemon/service.h"

namespace risorius {
namespace {

constexpr double kLongestNeutralSeconds = 60;

/// Refuses what a command does not take: stream (text), seconds (a number).
void expect_only(const nlohmann::json& request, bool stream, bool seconds) {
  for (const auto& [key, value] : request.items()) {
    const bool fits = key == "command" || (stream && key == "stream" && value.is_string()) ||
                      (seconds && key == "seconds" && value.is_number());
    if (fits) continue;
    throw UserError(shown(key),
                    shown(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) + " is not known here",
                    seconds  ? "give stream (text) and seconds (a number)"
                    : stream ? "give stream (text)"
                             : "give command alone");
  }
}

}  // namespace

nlohmann::json Service::answer(const nlohmann::json& request) {
  const auto command = request.at("command").get<std::string>();
  if (command == "capture_neutral") return capture_neutral(request);
  if (command == "go_to") return go_to(request);
  if (command == "release") return release(request);
  if (command == "status") {
    expect_only(request, false, false);
    return {{"ok", true}, {"status", status()}};
  }
  if (command == "stop") {
    expect_only(request, false, false);
    // After the answer has left.
    boost::asio::post(io_, [this] { stop(); });
    return {{"ok", true}};
  }
  throw UserError("command", shown(command) + " is not known", "capture_neutral, go_to, release, status or stop");
}

nlohmann::json Service::capture_neutral(const nlohmann::json& request) {
  expect_only(request, true, true);
  const double seconds = request.value("seconds", 1.0);
  if (!(seconds > 0 && seconds <= kLongestNeutralSeconds)) {
    throw UserError("seconds", fmt::format("{} is out of range", seconds), "give more than 0 and at most 60");
  }
  StreamInput& input = inputs_[stream_of(request)];
  if (!input.admit_neutral_capture(static_cast<std::int64_t>(seconds * 1e9))) {
    throw UserError(input.name(), "no frames are coming", "start the source first");
  }
  return {{"ok", true}, {"stream", input.name()}, {"seconds", seconds}};
}

nlohmann::json Service::go_to(const nlohmann::json& request) {
  const std::uint32_t i = stream_of(request);
  // The pipeline thread's own rig is not ours to read: a live neutral replaces it.
  const LiveTargetRequest asked = live_target_of(request, streams_[i].actor()->rig.au_names());
  const double seconds = shown_->go_to(i, asked);
  look_for_silence();
  return {{"ok", true}, {"stream", inputs_[i].name()}, {"seconds", seconds}, {"masked", asked.masked}};
}

nlohmann::json Service::release(const nlohmann::json& request) {
  expect_only(request, true, false);
  const std::uint32_t i = stream_of(request);
  shown_->release(i);
  return {{"ok", true}, {"stream", inputs_[i].name()}};
}

std::uint32_t Service::stream_of(const nlohmann::json& request) const {
  if (request.contains("stream") && !request["stream"].is_string()) {
    throw UserError("stream", shown(request["stream"].dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)),
                    "give the stream's name, a text");
  }
  const auto name = request.value("stream", std::string());
  for (std::uint32_t i = 0; i < inputs_.size(); ++i) {
    if (inputs_[i].name() == name || (name.empty() && inputs_.size() == 1)) return i;
  }
  std::string names;
  for (const auto& input : inputs_) names += (names.empty() ? "" : ", ") + input.name();
  throw UserError("stream", name.empty() ? "must be given, there are several" : shown(name) + " is not known",
                  "streams: " + names);
}

}  // namespace risorius
