#include "capture/repair/head_take.h"

#include <algorithm>
#include <cmath>

#include "capture/repair/frame_clock.h"
#include "capture/repair/position_vector.h"

namespace risorius {
namespace {

RigidTransform between(const RigidTransform& a, const RigidTransform& b, double share) noexcept {
  return {a.rotation.slerp(share, b.rotation), (1 - share) * a.translation + share * b.translation};
}

void bridge_poses(HeadTake& take, const std::vector<std::uint8_t>& determined) {
  const auto first = std::find(determined.begin(), determined.end(), 1);
  if (first == determined.end()) return;
  take.has_pose = true;
  auto before = static_cast<std::size_t>(first - determined.begin());
  for (std::size_t f = 0; f < before; ++f) take.head_from_world[f] = take.head_from_world[before];
  for (std::size_t f = before + 1; f < take.frames; ++f) {
    if (!determined[f]) {
      take.head_from_world[f] = take.head_from_world[before];
      continue;
    }
    for (std::size_t k = before + 1; k < f; ++k) {
      const double span_s = take.time_s[f] - take.time_s[before];
      const double share = span_s > 0 ? (take.time_s[k] - take.time_s[before]) / span_s : 0.5;
      take.head_from_world[k] = between(take.head_from_world[before], take.head_from_world[f], share);
    }
    before = f;
  }
}

}  // namespace

void HeadTake::set_filled(MarkerFrame& frame, std::size_t f, std::size_t i, const Eigen::Vector3d& position_head_mm,
                          double standard_deviation_mm) const noexcept {
  frame.position_mm[i] = to_position(head_from_world[f].inverse() * position_head_mm);
  frame.standard_deviation_mm[i] = static_cast<float>(standard_deviation_mm);
  frame.state[i] = MarkerState::kFilled;
}

HeadTake carry_into_head_frame(const std::vector<MarkerFrame>& frames, const MarkerSet& set,
                               const HeadFrameOptions& options) {
  HeadTake take;
  take.frames = frames.size();
  take.markers = set.names.size();
  take.position_mm.assign(take.frames * take.markers, Eigen::Vector3d::Zero());
  take.measured.resize(take.frames * take.markers);
  take.head_from_world.resize(take.frames);
  take.time_s.resize(take.frames);
  std::vector<std::uint8_t> determined(take.frames);
  HeadFrame head(options);
  head.use_names(set.names);
  for (const bool learning : {true, false}) {
    FrameClock clock;
    clock.reset(set.rate_hz);
    for (std::size_t f = 0; f < take.frames; ++f) {
      const double step_s = clock.advance(frames[f].header.capture_time_ns);
      if (f > 0) take.time_s[f] = take.time_s[f - 1] + step_s;
      const bool good = head.process(frames[f]);
      if (learning) {
        if (good) head.learn(step_s, head.measured());
        continue;
      }
      determined[f] = good;
      if (good) take.head_from_world[f] = head.head_from_world();
      for (std::size_t i = 0; i < take.markers; ++i) take.measured[take.at(f, i)] = head.measured()[i];
    }
  }
  bridge_poses(take, determined);
  for (std::size_t f = 0; f < take.frames; ++f) {
    for (std::size_t i = 0; i < take.markers; ++i) {
      if (!take.measured[take.at(f, i)]) continue;
      take.position_mm[take.at(f, i)] = take.head_from_world[f] * to_vector(frames[f].position_mm[i]);
    }
  }
  return take;
}

}  // namespace risorius
