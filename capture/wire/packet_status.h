// What stands at the front of a stream of bytes that is cut into packets.
#pragma once

#include <cstdint>

namespace risorius {

enum class PacketStatus : std::uint8_t {
  kIncomplete,  ///< more bytes are needed to tell
  kWhole,
  kBad,  ///< cannot be the beginning of a packet; the stream cannot be resynchronised
};

}  // namespace risorius
