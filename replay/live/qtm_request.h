// What a client of QTM's real-time protocol asks for, as far as streaming is concerned.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/wire/qtm_codec.h"

namespace risorius {

/// Words of a command, in lower case: QTM does not distinguish.
std::vector<std::string> qtm_words(std::string_view command);

struct QtmStreamRequest {
  enum class Rate : std::uint8_t { kAllFrames, kFrequency, kDivisor };
  Rate rate = Rate::kAllFrames;
  std::uint32_t rate_argument = 1;  ///< Hz, or every n-th frame
  bool udp = false;
  std::string udp_address;  ///< "": the client's
  std::uint16_t udp_port = 0;
  QtmComponents components;
};

/// The words after StreamFrames. Empty if QTM would not understand them.
std::optional<QtmStreamRequest> parse_qtm_stream_request(const std::vector<std::string>& words, std::size_t first);

/// Components from words[first] on; empty if there is none or one that QTM does not know. Those that have nothing to do
/// with markers are known and give nothing.
std::optional<QtmComponents> parse_qtm_components(const std::vector<std::string>& words, std::size_t first);

}  // namespace risorius
