// The values that travel through Risorius: marker frames, AU frames, continuations and ticks.
// All are trivially copyable and of fixed capacity; a default-constructed value means "nothing seen".
// Positions are millimetres in the world axes of capture/marker_set.h (x to the subject's left, y up, z out of the
// face), rounded to float once, in the reader or codec. Times are nanoseconds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace risorius {

inline constexpr std::size_t kMaxMarkers = 256;
inline constexpr std::size_t kMaxAus = 64;
inline constexpr std::size_t kMaxContinuationSteps = 32;

enum class MarkerState : std::uint8_t { kMissing, kMeasured, kFilled, kRejected };

/// Why a stage of repair took a measured position for false. Stays with the marker after it is filled.
enum class RejectReason : std::uint8_t { kNone, kJump, kDeviation, kNeighbourDistance, kGhost, kSwap, kNotFinite };

/// SMPTE timecode as the tracker sent it; `frame_rate` 0 means that there was none.
struct Timecode {
  std::uint8_t hours = 0;
  std::uint8_t minutes = 0;
  std::uint8_t seconds = 0;
  std::uint8_t frames = 0;
  std::uint8_t frame_rate = 0;
  bool drop_frame = false;

  /// Does a clock of this rate ever show it?
  constexpr bool possible() const noexcept { return hours < 24 && minutes < 60 && seconds < 60 && frames < frame_rate; }
};

struct FrameHeader {
  std::uint32_t stream_id = 0;       ///< which [[source]] or take
  std::uint32_t set_id = 0;          ///< marker-set id, or AU-set id in an AuFrame
  std::uint64_t sequence = 0;        ///< as the tracker counted
  std::int64_t capture_time_ns = 0;  ///< the tracker's clock
  std::int64_t receive_time_ns = 0;  ///< CLOCK_MONOTONIC right after the receive call; 0 offline; no stage reads it
  Timecode timecode;
};

struct Position {
  float x = 0, y = 0, z = 0;
  friend bool operator==(const Position&, const Position&) = default;
};

/// One frame of markers; entry i belongs to name i of the marker set `header.set_id`.
struct MarkerFrame {
  FrameHeader header;
  std::uint32_t count = 0;
  std::array<MarkerState, kMaxMarkers> state{};
  std::array<RejectReason, kMaxMarkers> reason{};
  std::array<Position, kMaxMarkers> position_mm{};
  std::array<float, kMaxMarkers> standard_deviation_mm{};  ///< of filled markers, per axis
};

/// kNotObserved: no visible marker informs the AU. kHeld: not observed now, the value is the last observed one.
enum class AuState : std::uint8_t { kNotObserved, kObserved, kHeld };
/// kSolved: a measurement, from markers. kMapped: a proxy, from a face tracker's own shapes; it has neither head pose,
/// residuals nor standard deviations.
enum class AuFrameKind : std::uint8_t { kSolved, kPredicted, kMapped };
/// kPoorFit: the markers are so far from anything that the rig can be that the rig cannot be this face in this unit.
/// kMirrored: their mirror image fits the rig, they do not: the source's axes are stated wrongly.
/// kMapped, kNoFace: of mapped frames; the face tracker saw a face, or none.
enum class SolverStatus : std::uint8_t {
  kNotSolved,
  kConverged,
  kIterationLimit,
  kTooFewMarkers,
  kPoorFit,
  kMirrored,
  kMapped,
  kNoFace
};
inline constexpr std::size_t kSolverStatusCount = 8;

/// p_world = rotation * p_head + translation.
struct Pose {
  std::array<double, 4> rotation_xyzw{0, 0, 0, 1};
  std::array<double, 3> translation_mm{};
};

/// One frame of AU intensities; entry i belongs to name i of the AU set `header.set_id`.
struct AuFrame {
  FrameHeader header;
  std::uint32_t count = 0;
  AuFrameKind kind = AuFrameKind::kSolved;
  SolverStatus status = SolverStatus::kNotSolved;
  Pose world_from_head;
  double residual_rms_mm = 0;  ///< over the measured markers, per marker (3D distance)
  double kkt_residual = 0;     ///< || x - clip(x - D^-1 g, 0, ub) ||_inf of the whole objective
  std::array<AuState, kMaxAus> state{};
  std::array<double, kMaxAus> intensity{};           ///< 0 to the rig's bound (1.2)
  std::array<double, kMaxAus> standard_deviation{};  ///< NaN: not known
};

/// AU vectors ahead of the frame `header`: step s lies `ahead_ns[s]` after `header.capture_time_ns`.
struct Continuation {
  FrameHeader header;
  std::uint32_t step_count = 0;
  std::uint32_t au_count = 0;
  std::array<std::int64_t, kMaxContinuationSteps> ahead_ns{};
  std::array<std::array<float, kMaxAus>, kMaxContinuationSteps> intensity{};
  std::array<std::array<float, kMaxAus>, kMaxContinuationSteps> standard_deviation{};
};

/// Time that passes without a frame. Where a stage must act on time alone it acts on a Tick, which is recorded like a
/// frame.
struct Tick {
  std::uint32_t stream_id = 0;
  std::int64_t time_ns = 0;  ///< the clock that `receive_time_ns` is read from
};

/// later - earlier, for times from anywhere: saturates instead of overflowing.
constexpr std::int64_t difference_ns(std::int64_t later, std::int64_t earlier) noexcept {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(later, earlier, &difference)) return difference;
  return later < earlier ? INT64_MIN : INT64_MAX;
}

static_assert(std::is_trivially_copyable_v<MarkerFrame> && std::is_trivially_copyable_v<AuFrame> &&
              std::is_trivially_copyable_v<Continuation> && std::is_trivially_copyable_v<Tick>);

}  // namespace risorius
