#include "solve/au_penalties.h"

#include <algorithm>
#include <cmath>

#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

/// The time step at which the temporal penalty has its nominal weight, and the shortest one believed.
constexpr double kNominalStep_s = 1.0 / 60, kShortestStep_s = 1e-4;
/// Over which the speed of an AU is averaged: long enough not to take noise for motion, short beside an onset.
constexpr double kSpeedMemory_s = 0.023;

std::vector<std::pair<int, int>> left_right_pairs(const Rig& rig) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < rig.au_count(); ++i) {
    const auto left = parse_au_name(rig.aus[i].name);
    if (!left || left->side != AuSide::kLeft) continue;
    for (std::size_t j = 0; j < rig.au_count(); ++j) {
      if (rig.aus[j].name != format_au_name({left->number, AuSide::kRight})) continue;
      pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  }
  return pairs;
}

}  // namespace

AuPenalties::AuPenalties(const Rig& rig, const AuSolverOptions& options, double unit_mm2)
    : options_(options),
      unit_mm2_(unit_mm2),
      left_right_pairs_(left_right_pairs(rig)),
      temporal_mm2_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rig.au_count()))),
      previous_(temporal_mm2_),
      speed_per_s_(temporal_mm2_) {
  expect_residuals(options.noise_mm * options.noise_mm);
}

bool AuPenalties::begin_frame(std::span<const char> follows, const Eigen::VectorXd& previous, double step_s) noexcept {
  step_s = step_s > 0 ? std::max(step_s, kShortestStep_s) : 0;
  const double weight = step_s > 0 ? options_.temporal * kNominalStep_s / step_s : 0;
  const double renewed = last_step_s_ > 0 ? 1 - std::exp(-last_step_s_ / kSpeedMemory_s) : 0;
  bool changed = false;
  for (std::size_t i = 0; i < follows.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (renewed > 0) speed_per_s_[k] += renewed * ((previous[k] - previous_[k]) / last_step_s_ - speed_per_s_[k]);
    if (!follows[i] || step_s == 0) speed_per_s_[k] = 0;
    const double haste = speed_per_s_[k] / options_.temporal_speed;
    const double temporal_mm2 = follows[i] ? weight * unit_mm2_ / (1 + haste * haste) : 0;
    changed = changed || temporal_mm2 != temporal_mm2_[k];
    temporal_mm2_[k] = temporal_mm2;
  }
  previous_ = previous;
  last_step_s_ = step_s;
  return changed;
}

void AuPenalties::add_to_hessian(Eigen::MatrixXd& h) const noexcept {
  h.diagonal().array() += options_.ridge * unit_mm2_ + temporal_mm2_.array();
  const double tie = options_.left_right * unit_mm2_;
  for (const auto& [left, right] : left_right_pairs_) {
    h(left, left) += tie;
    h(right, right) += tie;
    h(left, right) -= tie;
    h(right, left) -= tie;
  }
}

void AuPenalties::add_to_gradient(Eigen::VectorXd& b) const noexcept {
  b.array() += temporal_mm2_.array() * previous_.array() - l1_mm2_;
}

}  // namespace risorius
