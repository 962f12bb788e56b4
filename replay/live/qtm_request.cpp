#include "replay/live/qtm_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

namespace risorius {
namespace {

constexpr std::array<std::string_view, 15> kOtherComponents{
    "2d",    "2dlin",       "6d",         "6dres",      "6deuler", "6deulerres", "analog",         "analogsingle",
    "force", "forcesingle", "gazevector", "eyetracker", "image",   "skeleton",   "skeleton:global"};

std::optional<std::uint32_t> number_of(std::string_view text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

bool read_rate(std::string_view word, QtmStreamRequest& request) {
  constexpr std::string_view kFrequency = "frequency:", kDivisor = "frequencydivisor:";
  if (word == "allframes") return true;
  const bool by_divisor = word.starts_with(kDivisor);
  if (!by_divisor && !word.starts_with(kFrequency)) return false;
  request.rate = by_divisor ? QtmStreamRequest::Rate::kDivisor : QtmStreamRequest::Rate::kFrequency;
  const auto number = number_of(word.substr(by_divisor ? kDivisor.size() : kFrequency.size()));
  request.rate_argument = number.value_or(0);
  return request.rate_argument > 0;
}

/// "udp:PORT" or "udp:ADDRESS:PORT".
bool read_udp(std::string_view word, QtmStreamRequest& request) {
  request.udp = true;
  const std::string_view rest = word.substr(std::string_view("udp:").size());
  const auto colon = rest.rfind(':');
  if (colon != std::string_view::npos) request.udp_address = rest.substr(0, colon);
  const auto port = number_of(colon == std::string_view::npos ? rest : rest.substr(colon + 1));
  if (!port || *port == 0 || *port > 65535) return false;
  request.udp_port = static_cast<std::uint16_t>(*port);
  return true;
}

bool read_component(std::string_view word, QtmComponents& components) {
  if (word == "all") {
    components = {
        .markers = true, .residuals = true, .unlabelled = true, .unlabelled_residuals = true, .timecode = true};
  } else if (word == "3d") {
    components.markers = true;
  } else if (word == "3dres") {
    components.residuals = true;
  } else if (word == "3dnolabels") {
    components.unlabelled = true;
  } else if (word == "3dnolabelsres") {
    components.unlabelled_residuals = true;
  } else if (word == "timecode") {
    components.timecode = true;
  } else {
    // Analog takes a list of channels: "analog:1-3".
    const auto name = word.starts_with("analog") ? word.substr(0, word.find(':')) : word;
    return std::find(kOtherComponents.begin(), kOtherComponents.end(), name) != kOtherComponents.end();
  }
  return true;
}

}  // namespace

std::vector<std::string> qtm_words(std::string_view command) {
  std::string lower(command);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  std::istringstream in(lower);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::optional<QtmComponents> parse_qtm_components(const std::vector<std::string>& words, std::size_t first) {
  QtmComponents components;
  for (std::size_t i = first; i < words.size(); ++i)
    if (!read_component(words[i], components)) return {};
  return first < words.size() ? std::optional(components) : std::nullopt;
}

std::optional<QtmStreamRequest> parse_qtm_stream_request(const std::vector<std::string>& words, std::size_t first) {
  QtmStreamRequest request;
  if (first >= words.size() || !read_rate(words[first], request)) return {};
  std::size_t next = first + 1;
  if (next < words.size() && words[next].starts_with("udp:") && !read_udp(words[next++], request)) return {};
  const auto components = parse_qtm_components(words, next);
  if (!components) return {};
  request.components = *components;
  return request;
}

}  // namespace risorius
