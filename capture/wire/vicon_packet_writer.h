// The writing side of vicon_codec.h: one packet of the Vicon DataStream protocol, object by object.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "capture/wire/byte_appender.h"
#include "capture/wire/vicon_codec.h"

namespace risorius {

/// Appends one packet: constructed at its beginning, the lengths are right after finish().
class ViconPacketWriter {
 public:
  explicit ViconPacketWriter(ByteAppender& out);
  void ids(ViconId id, std::span<const std::uint32_t> ids);
  void contents(std::span<const std::pair<std::uint32_t, std::uint32_t>> counts,
                std::span<const std::uint32_t> unchanged);
  void subject(const ViconSubject& subject);
  void timecode(const Timecode& timecode);
  /// Covariance and radius zero.
  void labelled(std::span<const ViconRecon> recons);
  void no_unlabelled();
  void latencies(std::span<const std::pair<std::string_view, double>> seconds);
  void frame_rate(std::string_view name, double hz);
  void i64(ViconId id, std::int64_t value);
  void u32(ViconId id, std::uint32_t value);
  void u8(ViconId id, std::uint8_t value);
  void finish();

 private:
  template <class Body>
  void object(ViconId id, Body body);
  void text(std::string_view text);

  ByteAppender& out_;
  std::size_t start_;
};

}  // namespace risorius
