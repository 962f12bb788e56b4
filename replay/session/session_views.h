// What viewers such as Foxglove show of a session: JSON with JSON schemas, made from published messages
// (live/messages.h), at 60 Hz at most. For looking at; the Ticks and AUs beside them are what was recorded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace risorius {

inline constexpr std::string_view kAuViewSchemaName = "risorius.Aus", kMarkerViewSchemaName = "foxglove.PointCloud";
std::string_view au_view_schema();
std::string_view marker_view_schema();

// `msgpack` is a message of topic au or markers, `utc_ns` its time. Empty text if it is no such message.

/// {"timestamp", "stream", "sequence", "kind", "status", "au": {name: intensity or null}, "residual_rms_mm"}
std::string au_view_json(std::span<const std::byte> msgpack, std::int64_t utc_ns);
/// A point cloud in metres, world axes; a point is x y z (float) and state (the letter's code). Missing markers are
/// left out.
std::string marker_view_json(std::span<const std::byte> msgpack, std::int64_t utc_ns);

/// At most 60 in a second, evenly where more come.
class ViewDecimator {
 public:
  bool takes(std::int64_t time_ns) noexcept {
    if (time_ns < due_ns_ && due_ns_ - time_ns <= kPeriodNs) return false;
    due_ns_ = time_ns - due_ns_ < kPeriodNs && time_ns >= due_ns_ ? due_ns_ + kPeriodNs : time_ns + kPeriodNs;
    return true;
  }

 private:
  static constexpr std::int64_t kPeriodNs = 1'000'000'000 / 60;
  std::int64_t due_ns_ = 0;
};

}  // namespace risorius
