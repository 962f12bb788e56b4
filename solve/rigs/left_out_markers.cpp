#include "solve/rigs/left_out_markers.h"

#include <algorithm>
#include <optional>

#include "capture/check.h"

namespace risorius {
namespace {

/// Where each marker stood and how far it had moved, by frame of the take; none where the frame was not solved.
struct Moved {
  Eigen::Matrix3Xd displacement_mm;
  Eigen::VectorXd measured;
};

}  // namespace

std::vector<std::vector<std::size_t>> marker_folds(const Rig& rig, std::size_t count) {
  RISORIUS_CHECK(count >= 2);
  std::vector<std::size_t> order;
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    if (rig.stabiliser_weight[static_cast<Eigen::Index>(m)] == 0) order.push_back(m);
  }
  // By height, so that neighbours in the order are of one region and fall into different groups.
  std::ranges::stable_sort(order, std::greater<>(),
                           [&](std::size_t m) { return rig.neutral_mm(1, static_cast<Eigen::Index>(m)); });
  std::vector<std::vector<std::size_t>> groups(count);
  for (std::size_t i = 0; i < order.size(); ++i) groups[i % count].push_back(order[i]);
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  return groups;
}

LeftOutEnergy left_out_energy(const Rig& rig, const TakeFrames& take,
                              const std::vector<std::vector<std::size_t>>& hidden_groups,
                              const AuSolverOptions& options) {
  std::vector<std::optional<Moved>> moved(take.frames.size());
  explain_take(rig, take, options, [&](const ExplainedFrame& frame) {
    moved[frame.index] = Moved{frame.displacement_mm, frame.measured};
  });
  const std::vector<int> index = index_map(take.markers.names, rig.marker_names);
  LeftOutEnergy energy;
  for (const std::vector<std::size_t>& group : hidden_groups) {
    TakeFrames shown = take;
    for (MarkerFrame& frame : shown.frames) {
      for (const std::size_t m : group) {
        if (index[m] >= 0) frame.state[static_cast<std::size_t>(index[m])] = MarkerState::kMissing;
      }
    }
    explain_take(rig, shown, options, [&](const ExplainedFrame& frame) {
      const std::optional<Moved>& truth = moved[frame.index];
      if (!truth) return;
      for (const std::size_t m : group) {
        const auto column = static_cast<Eigen::Index>(m);
        if (truth->measured[column] == 0) continue;
        const Position& p = take.frames[frame.index].position_mm[static_cast<std::size_t>(index[m])];
        Eigen::Vector3d foretold = rig.neutral_mm.col(column);
        for (std::size_t i = 0; i < rig.au_count(); ++i) {
          foretold += frame.x[static_cast<Eigen::Index>(i)] * rig.aus[i].displacement_mm.col(column);
        }
        energy.moved_mm2 += truth->displacement_mm.col(column).squaredNorm();
        energy.left_mm2 += (Eigen::Vector3d(p.x, p.y, p.z) - frame.world_from_head * foretold).squaredNorm();
        energy.samples += 1;
      }
    });
  }
  return energy;
}

}  // namespace risorius
