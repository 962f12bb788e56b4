#include "capture/repair/offline_repair.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/repair/frame_clock.h"
#include "capture/repair/gap_baselines.h"

namespace risorius {
namespace {

constexpr int kLearningPasses = 2;
/// Artificial gaps of 1, 2, 4 ... 256 missing frames.
constexpr std::size_t kLengths = 9;
/// Lengths that were seen seldom lean on the pool of all markers with this many samples.
constexpr double kPoolSamples = 50;
/// At an end of the take the last residual fades in this time.
constexpr double kResidualFadeS = 1.0;
constexpr double kTinyMm2 = 1e-12;

/// The take in the head's frame. Index: frame * markers + marker.
struct HeadTake {
  std::size_t frames = 0, markers = 0;
  std::vector<Eigen::Vector3d> position_mm, prediction_mm;
  std::vector<double> model_variance_mm2;
  std::vector<std::uint8_t> measured;
  std::vector<RigidTransform> head_from_world;
  std::vector<std::uint8_t> determined;

  std::size_t at(std::size_t f, std::size_t i) const noexcept { return f * markers + i; }
};

/// What a gap of one length needs: how far the truth and the prediction leave the straight line between the ends.
struct LineMoments {
  double truth = 0, cross = 0, prediction = 0, samples = 0;

  void add(const LineMoments& other, double scale) noexcept {
    truth += scale * other.truth;
    cross += scale * other.cross;
    prediction += scale * other.prediction;
    samples += scale * other.samples;
  }
  double beta() const noexcept { return std::clamp(cross / (prediction + kTinyMm2), 0.0, 1.0); }
  /// Mean squared error per axis inside such a gap.
  double variance_mm2() const noexcept {
    const double b = beta();
    return std::max(truth - 2 * b * cross + b * b * prediction, 0.0) / (3 * std::max(samples, 1.0));
  }
};
using MomentsByLength = std::array<LineMoments, kLengths>;

void check(const std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  if (options.max_gap_ns <= 0) {
    throw UserError("max_gap_ns", fmt::format("{} is not > 0", options.max_gap_ns),
                    "10000000000 (10 s) is the default");
  }
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}", set.id), problems.front(), "correct the take's marker set");
  }
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].count == set.names.size()) continue;
    throw UserError(fmt::format("frame {}", f),
                    fmt::format("it has {} markers, the set has {}", frames[f].count, set.names.size()),
                    "split the take where its marker set changes");
  }
}

void reject_not_finite(std::vector<MarkerFrame>& frames) noexcept {
  for (MarkerFrame& frame : frames) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      const Position p = frame.position_mm[i];
      if (frame.state[i] != MarkerState::kMeasured) continue;
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
      frame.state[i] = MarkerState::kRejected;
      frame.reason[i] = RejectReason::kNotFinite;
    }
  }
}

/// Passes over the take: learn reference and statistics, then predict every marker of every frame from the others.
HeadTake predict_take(const std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  HeadTake take;
  take.frames = frames.size();
  take.markers = set.names.size();
  take.position_mm.resize(take.frames * take.markers, Eigen::Vector3d::Zero());
  take.prediction_mm = take.position_mm;
  take.model_variance_mm2.resize(take.frames * take.markers);
  take.measured.resize(take.frames * take.markers);
  take.head_from_world.resize(take.frames);
  take.determined.resize(take.frames);
  HeadFrame head(options.head_frame);
  head.use_names(set.names);
  MarkerStatistics statistics(options.statistics);
  statistics.remap(std::vector<int>(take.markers, -1));
  for (int pass = 0; pass <= kLearningPasses; ++pass) {
    FrameClock clock;
    clock.reset(set.rate_hz);
    for (std::size_t f = 0; f < take.frames; ++f) {
      const double step_s = clock.advance(frames[f].header.capture_time_ns);
      if (options.progress && f % 256 == 0) {
        const double in_pass = static_cast<double>(f) / static_cast<double>(take.frames);
        options.progress((pass + in_pass) / (kLearningPasses + 1));
      }
      if (!head.process(frames[f])) continue;
      statistics.observe(head.position_head_mm(), head.measured());
      if (pass < kLearningPasses) {
        if (pass == 0) head.learn(step_s, head.measured());
        statistics.learn(step_s);
        continue;
      }
      take.determined[f] = 1;
      take.head_from_world[f] = head.head_from_world();
      for (std::size_t i = 0; i < take.markers; ++i) {
        const std::size_t at = take.at(f, i);
        take.measured[at] = head.measured()[i];
        take.position_mm[at] = head.position_head_mm()[i];
        take.prediction_mm[at] = statistics.prediction_mm(i);
        take.model_variance_mm2[at] = statistics.variance_mm2(i);
      }
    }
  }
  return take;
}

Eigen::Vector3d off_line(const std::vector<Eigen::Vector3d>& of, const HeadTake& take, std::size_t i, std::size_t from,
                         std::size_t to, std::size_t f) noexcept {
  const double share = static_cast<double>(f - from) / static_cast<double>(to - from);
  return of[take.at(f, i)] - (1 - share) * of[take.at(from, i)] - share * of[take.at(to, i)];
}

/// Artificial gaps, half overlapping, wherever the marker was measured at both ends.
MomentsByLength line_moments(const HeadTake& take, std::size_t i) noexcept {
  MomentsByLength moments;
  for (std::size_t k = 0; k < kLengths; ++k) {
    const std::size_t span = (std::size_t{1} << k) + 1;
    for (std::size_t from = 0; from + span < take.frames; from += std::max<std::size_t>(1, span / 2)) {
      if (!take.measured[take.at(from, i)] || !take.measured[take.at(from + span, i)]) continue;
      for (std::size_t f = from + 1; f < from + span; ++f) {
        if (!take.measured[take.at(f, i)]) continue;
        const Eigen::Vector3d truth = off_line(take.position_mm, take, i, from, from + span, f);
        const Eigen::Vector3d predicted = off_line(take.prediction_mm, take, i, from, from + span, f);
        moments[k].truth += truth.squaredNorm();
        moments[k].cross += truth.dot(predicted);
        moments[k].prediction += predicted.squaredNorm();
        moments[k].samples += 1;
      }
    }
  }
  return moments;
}

/// Longer lengths than the take has room for take the next shorter one's.
void lean_on_pool(std::vector<MomentsByLength>& moments) {
  for (std::size_t k = 0; k < kLengths; ++k) {
    LineMoments pool;
    for (const MomentsByLength& marker : moments) pool.add(marker[k], 1);
    for (MomentsByLength& marker : moments) {
      if (pool.samples > 0) marker[k].add(pool, kPoolSamples / pool.samples);
      if (pool.samples == 0 && k > 0) marker[k] = marker[k - 1];
    }
  }
}

class TakeFiller {
 public:
  TakeFiller(std::vector<MarkerFrame>& frames, const HeadTake& take, const OfflineFillOptions& options)
      : frames_(frames), take_(take), max_gap_ns_(options.max_gap_ns), moments_(take.markers) {
    for (std::size_t i = 0; i < take.markers; ++i) moments_[i] = line_moments(take, i);
    lean_on_pool(moments_);
  }

  void fill_marker(std::size_t i) {
    std::size_t last = take_.frames;  // none yet
    for (std::size_t f = 0; f < take_.frames; ++f) {
      if (!take_.measured[take_.at(f, i)]) continue;
      if (last == take_.frames) {
        fill_open_end(i, f, 0, f);
      } else if (f > last + 1 && fits(last, f)) {
        fill_between(i, last, f);
      }
      last = f;
    }
    if (last < take_.frames) fill_open_end(i, last, last + 1, take_.frames);
  }

 private:
  bool fits(std::size_t from, std::size_t to) const noexcept {
    return frames_[to].header.capture_time_ns - frames_[from].header.capture_time_ns <= max_gap_ns_;
  }

  void fill_between(std::size_t i, std::size_t from, std::size_t to) {
    const std::size_t span = to - from;
    const double position = std::min(std::log2(static_cast<double>(span - 1)), kLengths - 1.0);
    const LineMoments& moments = moments_[i][static_cast<std::size_t>(std::lround(position))];
    for (std::size_t f = from + 1; f < to; ++f) {
      const double share = static_cast<double>(f - from) / static_cast<double>(span);
      const Eigen::Vector3d line =
          (1 - share) * take_.position_mm[take_.at(from, i)] + share * take_.position_mm[take_.at(to, i)];
      const Eigen::Vector3d bend = off_line(take_.prediction_mm, take_, i, from, to, f);
      // A bridge between two known ends: its variance is a parabola, whose mean over the gap is 2/3 of its top.
      const double variance = 1.5 * moments.variance_mm2() * 4 * share * (1 - share);
      set(f, i, line + moments.beta() * bend, variance + moments_[i][0].variance_mm2());
    }
  }

  /// Only one end is known: the prediction, and the residual at that end, which fades.
  void fill_open_end(std::size_t i, std::size_t known, std::size_t begin, std::size_t end) {
    const Eigen::Vector3d residual = take_.position_mm[take_.at(known, i)] - take_.prediction_mm[take_.at(known, i)];
    for (std::size_t f = begin; f < end; ++f) {
      const double away_s = 1e-9 * std::abs(static_cast<double>(frames_[f].header.capture_time_ns) -
                                            static_cast<double>(frames_[known].header.capture_time_ns));
      if (away_s * 1e9 > static_cast<double>(max_gap_ns_)) continue;
      const double kept = std::exp(-away_s / kResidualFadeS);
      const double variance = take_.model_variance_mm2[take_.at(f, i)];
      set(f, i, take_.prediction_mm[take_.at(f, i)] + kept * residual, variance);
    }
  }

  void set(std::size_t f, std::size_t i, const Eigen::Vector3d& position_head_mm, double variance_mm2) {
    if (!take_.determined[f]) return;
    const Eigen::Vector3f p = (take_.head_from_world[f].inverse() * position_head_mm).cast<float>();
    frames_[f].position_mm[i] = {p.x(), p.y(), p.z()};
    frames_[f].standard_deviation_mm[i] = static_cast<float>(std::sqrt(variance_mm2));
    frames_[f].state[i] = MarkerState::kFilled;
  }

  std::vector<MarkerFrame>& frames_;
  const HeadTake& take_;
  std::int64_t max_gap_ns_;
  std::vector<MomentsByLength> moments_;
};

}  // namespace

void fill_offline(std::vector<MarkerFrame>& frames, const MarkerSet& set, const OfflineFillOptions& options) {
  check(frames, set, options);
  if (options.method != OfflineFillMethod::kNone) reject_not_finite(frames);
  if (options.method == OfflineFillMethod::kLinear) fill_linear(frames, options.max_gap_ns);
  if (options.method == OfflineFillMethod::kLowRank && !frames.empty()) {
    const HeadTake take = predict_take(frames, set, options);
    TakeFiller filler(frames, take, options);
    for (std::size_t i = 0; i < take.markers; ++i) filler.fill_marker(i);
  }
  if (options.progress) options.progress(1);
}

}  // namespace risorius
