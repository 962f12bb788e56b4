#include "capture/repair/residual_memory.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <ranges>

namespace risorius {
namespace {

constexpr double kQuickS = 0.02;
constexpr double kSlowS = 0.15;
/// Ticks after which half a regression's evidence is forgotten, about.
constexpr double kMemoryTicks = 1200;
/// The pool counts for so many samples of a marker. Successive samples are far from independent.
constexpr double kPoolSamples = 120;
constexpr std::int64_t kPoolEveryTicks = 16;
/// Two averages of a quiet marker are nearly collinear; this share of ridge keeps the regression tame.
constexpr double kRidge = 1e-3;
constexpr double kTiny = 1e-9;

double rate(double step_s, double time_constant_s) noexcept { return 1 - std::exp(-step_s / time_constant_s); }

}  // namespace

void ResidualMemory::Moments::fade(double keep) noexcept {
  s_s *= keep;
  e_s *= keep;
  e_e *= keep;
  model *= keep;
  weight *= keep;
}

void ResidualMemory::Moments::add(const Moments& other, double scale) noexcept {
  s_s += scale * other.s_s;
  e_s += scale * other.e_s;
  e_e += scale * other.e_e;
  model += scale * other.model;
  weight += scale * other.weight;
}

/// Before anything is known, a residual is believed to stay and to fade over the longest lag (unit variance per axis).
std::array<ResidualMemory::Moments, ResidualMemory::kLags> ResidualMemory::prior_pool() noexcept {
  std::array<Moments, kLags> pool;
  for (std::size_t lag = 0; lag < kLags; ++lag) {
    const double correlation = std::exp(-static_cast<double>(1 << lag) / kLongestLag);
    pool[lag].s_s << 3.0, 2.9, 2.9, 3.0;
    pool[lag].e_s << 3.0 * correlation, 2.9 * correlation;
    pool[lag].e_e = pool[lag].model = 3.0;
    pool[lag].weight = 1;
  }
  return pool;
}

void ResidualMemory::remap(const std::vector<int>& old_index) {
  // A source that starts again has the same markers: then nothing is allocated.
  if (std::ranges::equal(old_index, std::views::iota(0, static_cast<int>(markers_.size())))) return;
  std::vector<Marker> mapped(old_index.size());
  std::vector<Past> ring(kRing * old_index.size());
  for (std::size_t i = 0; i < old_index.size(); ++i) {
    if (old_index[i] < 0) continue;
    const auto old = static_cast<std::size_t>(old_index[i]);
    mapped[i] = markers_[old];
    for (std::size_t t = 0; t < kRing; ++t) ring[t * mapped.size() + i] = ring_[t * markers_.size() + old];
  }
  markers_ = std::move(mapped);
  ring_ = std::move(ring);
}

void ResidualMemory::reset() noexcept {
  std::fill(markers_.begin(), markers_.end(), Marker{});
  std::fill(ring_.begin(), ring_.end(), Past{});
  pool_ = prior_pool();
  frame_ = tick_ = 0;
  since_tick_s_ = 0;
  tick_s_ = kTickS;
}

void ResidualMemory::begin_frame(double step_s) noexcept {
  ++frame_;
  quick_rate_ = rate(step_s, kQuickS);
  slow_rate_ = rate(step_s, kSlowS);
  since_tick_s_ += step_s;
  is_tick_ = since_tick_s_ >= 0.99 * kTickS;
  if (!is_tick_) return;
  tick_s_ = since_tick_s_;
  since_tick_s_ = 0;
  ++tick_;
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    ring_[static_cast<std::size_t>(tick_ % kRing) * markers_.size() + i].valid = false;
  }
  if (tick_ % kPoolEveryTicks == 0) renew_pool();
}

void ResidualMemory::observe(std::size_t i, const Eigen::Vector3d& residual_mm, double variance_mm2) noexcept {
  Marker& marker = markers_[i];
  if (is_tick_) learn_lags(i, residual_mm, variance_mm2);
  if (marker.last_frame + 1 == frame_) {
    marker.level_mm.col(0) += quick_rate_ * (residual_mm - marker.level_mm.col(0));
    marker.level_mm.col(1) += slow_rate_ * (residual_mm - marker.level_mm.col(1));
  } else {
    marker.level_mm.colwise() = residual_mm;
  }
  marker.last_frame = frame_;
  if (is_tick_) ring_[static_cast<std::size_t>(tick_ % kRing) * markers_.size() + i] = {marker.level_mm, true};
}

void ResidualMemory::refine(std::size_t i, const Eigen::Vector3d& residual_mm, double step_s) noexcept {
  Marker& marker = markers_[i];
  follow(marker.level_mm, residual_mm, step_s, marker.last_frame == frame_);
}

void ResidualMemory::follow(Level& level_mm, const Eigen::Vector3d& residual_mm, double step_s, bool goes_on) noexcept {
  if (goes_on) {
    level_mm.col(0) += rate(step_s, kQuickS) * (residual_mm - level_mm.col(0));
    level_mm.col(1) += rate(step_s, kSlowS) * (residual_mm - level_mm.col(1));
  } else {
    level_mm.colwise() = residual_mm;
  }
}

void ResidualMemory::learn_lags(std::size_t i, const Eigen::Vector3d& residual_mm, double variance_mm2) noexcept {
  for (std::size_t lag = 0; lag < kLags; ++lag) {
    const std::int64_t then = tick_ - (1 << lag);
    if (then < 1) continue;
    const Past& past = ring_[static_cast<std::size_t>(then % kRing) * markers_.size() + i];
    if (!past.valid) continue;
    Moments& moments = markers_[i].moments[lag];
    moments.fade(1 - 1 / kMemoryTicks);
    moments.s_s.noalias() += past.level_mm.transpose() * past.level_mm;
    moments.e_s.noalias() += past.level_mm.transpose() * residual_mm;
    moments.e_e += residual_mm.squaredNorm();
    moments.model += 3 * variance_mm2;
    moments.weight += 1;
  }
}

/// The pool has unit variance per axis: markers count alike, whatever their scale.
void ResidualMemory::renew_pool() noexcept {
  std::array<Moments, kLags> pool = prior_pool();
  for (std::size_t lag = 0; lag < kLags; ++lag) {
    pool[lag].fade(kPoolSamples);
    for (const Marker& marker : markers_) {
      const Moments& own = marker.moments[lag];
      if (own.weight > 0) pool[lag].add(own, 3 * own.weight / (own.e_e + kTiny));
    }
    pool[lag].fade(1 / pool[lag].weight);
  }
  pool_ = pool;
}

ResidualMemory::Forecast ResidualMemory::forecast_at_lag(const Level& level_mm, const Marker& marker, std::size_t lag,
                                                         double variance_mm2) const noexcept {
  // The pool takes the marker's scale: its own residual where it has samples, the model's claim where it has none.
  Moments moments = marker.moments[lag];
  const double own = moments.weight > 0 ? moments.e_e / (3 * moments.weight) : variance_mm2;
  const double claimed = moments.weight > 0 ? moments.model / (3 * moments.weight) : variance_mm2;
  Moments pool = pool_[lag];
  pool.model *= claimed / (own + kTiny) * 3 / (pool.model + kTiny);
  moments.add(pool, kPoolSamples * (own + kTiny));

  const double ridge = kRidge * moments.s_s.trace() + kTiny;
  const Eigen::Vector2d gain = (moments.s_s + ridge * Eigen::Matrix2d::Identity()).ldlt().solve(moments.e_s);
  const double squared = moments.e_e - 2 * gain.dot(moments.e_s) + gain.dot(moments.s_s * gain);
  Forecast forecast;
  forecast.residual_mm = level_mm * gain;
  // What the regression missed, scaled by how much more (or less) the model knows now than it did on average.
  const double knows_less = variance_mm2 / (moments.model / (3 * moments.weight) + kTiny);
  forecast.variance_mm2 = std::max(squared, 0.0) / (3 * moments.weight) * knows_less;
  return forecast;
}

ResidualMemory::Forecast ResidualMemory::forecast_from(const Level& level_mm, std::size_t i, double gap_s,
                                                       double variance_mm2) const noexcept {
  const double ticks = std::max(1.0, gap_s / tick_s_);
  const double position = std::min(std::log2(ticks), kLags - 1.0);
  const auto lower = static_cast<std::size_t>(position);
  const std::size_t upper = std::min(lower + 1, static_cast<std::size_t>(kLags - 1));
  const double share = position - static_cast<double>(lower);
  const Forecast near = forecast_at_lag(level_mm, markers_[i], lower, variance_mm2);
  const Forecast far = upper == lower ? near : forecast_at_lag(level_mm, markers_[i], upper, variance_mm2);
  const double beyond = std::min(1.0, kLongestLag / ticks);  // past the longest lag the memory fades
  return {beyond * ((1 - share) * near.residual_mm + share * far.residual_mm),
          ((1 - share) * near.variance_mm2 + share * far.variance_mm2) / beyond};
}

}  // namespace risorius
