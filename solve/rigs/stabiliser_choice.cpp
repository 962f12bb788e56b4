#include "solve/rigs/stabiliser_choice.h"

#include <algorithm>
#include <cmath>

#include "solve/rigs/stabilisers.h"

namespace risorius {
namespace {

constexpr double kCalmMm = 0.8;       // unrest at which a marker's weight has halved
constexpr double kActedMm = 2.5;      // the largest displacement by an AU at which it has halved
constexpr double kLeastWeight = 0.2;  // of the best: below, a marker is no stabiliser

}  // namespace

StabiliserChoice choose_by_unrest(const Rig& rig, const Eigen::VectorXd& unrest_mm, double moving_mm) {
  StabiliserChoice choice{rig.stabiliser_weight, {}, {}};
  const auto moves = [&](Eigen::Index m) { return unrest_mm[m] > moving_mm; };
  bool any_moves = false;
  for (Eigen::Index m = 0; m < unrest_mm.size(); ++m) any_moves |= rig.stabiliser_weight[m] > 0 && moves(m);
  if (!any_moves) return choice;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(unrest_mm.size());
  for (Eigen::Index m = 0; m < unrest_mm.size(); ++m) {
    if (std::isnan(unrest_mm[m]) || moves(m)) continue;
    double acted_mm = 0;
    for (const RigAu& au : rig.aus) acted_mm = std::max(acted_mm, au.displacement_mm.col(m).norm());
    const double unrest = unrest_mm[m] / kCalmMm, acted = acted_mm / kActedMm;
    weight[m] = 1 / ((1 + unrest * unrest) * (1 + acted * acted));
  }
  if (!(weight.maxCoeff() > 0)) return choice;
  weight /= weight.maxCoeff();
  weight = (weight.array() < kLeastWeight).select(0, weight);
  if (!hold_still(rig.neutral_mm, weight)) return choice;
  for (Eigen::Index m = 0; m < weight.size(); ++m) {
    if (rig.stabiliser_weight[m] > 0 && weight[m] == 0) choice.dropped.push_back(static_cast<std::size_t>(m));
    if (rig.stabiliser_weight[m] == 0 && weight[m] > 0) choice.added.push_back(static_cast<std::size_t>(m));
  }
  choice.weight = weight;
  return choice;
}

}  // namespace risorius
