// The MessagePack maps that the daemon publishes (daemon/README.md). Pure functions from values to bytes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "generate/shown_face.h"

namespace risorius {

/// What every message says beside its frame.
struct MessageContext {
  std::string_view stream;    ///< the source's name
  std::uint64_t message = 0;  ///< counts the messages of this topic and stream from 0: a gap is the client's own drop
  std::int64_t publish_time_ns = 0;    ///< CLOCK_MONOTONIC
  std::span<const std::string> names;  ///< of the markers or AUs, in the frame's order
};

/// A buffer that is reused: encode_* clears it, and it grows only until it has held the largest message.
using MessageBuffer = std::vector<char>;

/// names.size() == frame.count in all of them.
void encode_markers(const MarkerFrame& frame, const MessageContext& context, MessageBuffer& out);
void encode_aus(const AuFrame& frame, const MessageContext& context, MessageBuffer& out);
void encode_shown(const ShownFrame& shown, const MessageContext& context, MessageBuffer& out);
void encode_continuation(const Continuation& continuation, const MessageContext& context, MessageBuffer& out);

}  // namespace risorius
