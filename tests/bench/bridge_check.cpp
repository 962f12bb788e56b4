#include "bench/bridge_check.h"

#include <algorithm>
#include <cmath>

#include "generate/continuation_models.h"
#include "generate/shown_face.h"
#include "replay/performer/random.h"

namespace risorius::bench {
namespace {

constexpr double kWarmUp_s = 5;  // of frames before a drop-out
constexpr std::int64_t kInstant_ns = 1'000'000;

/// The largest change of a moving AU.
double largest_step(const ContinuationTake& take, const AuFrame& from, const AuFrame& to) {
  double largest = 0;
  for (const std::size_t au : take.moving) largest = std::max(largest, std::abs(to.intensity[au] - from.intensity[au]));
  return largest;
}

double mean_error(const ContinuationTake& take, const AuFrame& shown, const AuFrame& truth) {
  double sum = 0;
  for (const std::size_t au : take.moving) sum += std::abs(shown.intensity[au] - truth.intensity[au]);
  return sum / static_cast<double>(take.moving.size());
}

}  // namespace

BridgeCheck check_bridges(const ContinuationTake& take, double drop_out_ms, int draws, std::uint64_t seed) {
  BridgeCheck check;
  const auto lost = static_cast<std::size_t>(std::lround(drop_out_ms * 1e-3 * take.rate_hz));
  const auto warm_up = static_cast<std::size_t>(kWarmUp_s * take.rate_hz);
  if (lost < 1 || take.frames.size() < warm_up + lost + 2 || take.moving.empty()) return check;
  Random random(seed, static_cast<std::uint64_t>(drop_out_ms));
  double lost_frames = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const std::size_t last = warm_up + random.index(take.frames.size() - warm_up - lost - 1);
    Continuer continuer(make_continuation_model({}, take.aus, take.upper_bounds));
    ShownFace face(take.upper_bounds, {.max_rate_hz = 1000});
    Continuation continuation;
    ShownFrame before, shown;
    for (std::size_t f = last - warm_up; f <= last; ++f) {
      face.process(take.frames[f], before);
      if (continuer.process(take.frames[f], continuation)) face.use(continuation);
    }
    if (before.aus.header.capture_time_ns != take.frames[last].header.capture_time_ns) continue;  // had no AUs
    ++check.drop_outs;
    const std::int64_t last_ns = before.aus.header.capture_time_ns;
    face.pass(kInstant_ns, shown);
    check.largest_step_at_start = std::max(check.largest_step_at_start, largest_step(take, before.aus, shown.aus));
    for (std::size_t f = last + 1; f <= last + lost; ++f) {
      face.pass(take.frames[f].header.capture_time_ns - last_ns, shown);
      check.mean_error += mean_error(take, shown.aus, take.frames[f]);
      check.mean_error_of_hold += mean_error(take, take.frames[last], take.frames[f]);
      ++lost_frames;
    }
    const AuFrame& next = take.frames[last + lost + 1];
    face.pass(next.header.capture_time_ns - last_ns - kInstant_ns, before);
    if (!face.process(next, shown)) continue;
    check.largest_step_at_end = std::max(check.largest_step_at_end, largest_step(take, before.aus, shown.aus));
    check.mean_jump_without += largest_step(take, take.frames[last], next);
  }
  if (check.drop_outs == 0) return check;
  check.mean_jump_without /= check.drop_outs;
  check.mean_error /= lost_frames;
  check.mean_error_of_hold /= lost_frames;
  return check;
}

}  // namespace risorius::bench
