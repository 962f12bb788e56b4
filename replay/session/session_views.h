// What viewers such as Foxglove show of a session: JSON with JSON schemas, made from published messages
// (live/messages.h), at 60 Hz at most. For looking at; the Ticks and AUs beside them are what was recorded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

inline constexpr std::string_view kMarkerViewSchemaName = "foxglove.PointCloud";
/// Viewers tell types apart by name, and streams may have other AUs.
inline std::string au_view_schema_name(std::string_view stream) { return "risorius.Aus." + std::string(stream); }
/// Of a stream with these AUs.
std::string au_view_schema(const std::vector<std::string>& au_names);
std::string_view marker_view_schema();

// `msgpack` is a message of topic au or markers, `utc_ns` its time. Empty text if it is no such message.

/// {"timestamp", "stream", "sequence", "kind", "status", "au": {name: intensity}, "residual_rms_mm"}; what is unknown
/// is left out.
std::string au_view_json(std::span<const std::byte> msgpack, std::int64_t utc_ns);
/// A point cloud in metres, world axes, with a pose that sets it upright where z is up; a point is x y z (float) and
/// state (the letter's code). Missing markers are left out.
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
