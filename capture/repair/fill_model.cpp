#include "capture/repair/fill_model.h"

#include <algorithm>
#include <cmath>

namespace risorius {

void FillModel::remap(const std::vector<int>& old_index) {
  std::vector<Eigen::Vector3d> stayed(old_index.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < stayed.size(); ++i) {
    if (old_index[i] >= 0) stayed[i] = stayed_head_mm_[static_cast<std::size_t>(old_index[i])];
  }
  stayed_head_mm_ = std::move(stayed);
  covariance_.remap(old_index);
  residuals_.remap(old_index);
}

void FillModel::reset() noexcept {
  covariance_.reset();
  residuals_.reset();
  std::fill(stayed_head_mm_.begin(), stayed_head_mm_.end(), Eigen::Vector3d::Zero());
  since_tick_s_ = 0;
}

void FillModel::observe(const std::vector<Eigen::Vector3d>& position_head_mm, const std::vector<std::uint8_t>& measured,
                        double step_s) noexcept {
  const double follow = 1 - std::exp(-step_s / kLatelyS);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i]) continue;
    const double rate = covariance_.visible(i) ? follow : 1;  // who comes back is where it is
    stayed_head_mm_[i] += rate * (position_head_mm[i] - stayed_head_mm_[i]);
  }
  // Of a marker that goes, the frames since the last tick are the freshest word.
  for (std::size_t i = 0; covariance_.has_unlearnt() && i < measured.size(); ++i) {
    if (measured[i] || !covariance_.visible(i)) continue;
    residuals_.refine(i, covariance_.mean_residual_mm(i), since_tick_s_);
  }
  covariance_.observe(position_head_mm, measured);
  take_over_shifts(measured);
}

void FillModel::take_over_shifts(const std::vector<std::uint8_t>& measured) noexcept {
  if (!covariance_.has_shifted()) return;
  for (std::size_t i = 0; i < measured.size(); ++i) residuals_.shift(i, covariance_.shift_mm(i));
}

void FillModel::learn(const std::vector<std::uint8_t>& measured, double step_s, bool is_informed) noexcept {
  since_tick_s_ += step_s;
  if (since_tick_s_ < 0.99 * ResidualMemory::kTickS) return;
  residuals_.begin_frame(since_tick_s_);
  if (is_informed) {
    covariance_.prepare_to_learn();
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (measured[i]) residuals_.observe(i, covariance_.mean_residual_mm(i), covariance_.variance_mm2(i));
    }
    covariance_.learn(since_tick_s_);
    take_over_shifts(measured);
  }
  since_tick_s_ = 0;
}

MarkerFill FillModel::estimate(std::size_t i, double gap_s) noexcept {
  const ResidualMemory::Forecast forecast = residuals_.forecast(i, gap_s, covariance_.variance_mm2(i));
  return {covariance_.prediction_mm(i) + forecast.residual_mm, forecast.variance_mm2};
}

}  // namespace risorius
