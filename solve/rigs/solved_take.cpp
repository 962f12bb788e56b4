#include "solve/rigs/solved_take.h"

#include <algorithm>

#include "capture/check.h"
#include "capture/errors.h"
#include "solve/au_solver.h"

namespace risorius {
namespace {

constexpr double kLongestStep_s = 0.2;  // a hole in the take is no time in which the face was seen

RigidTransform transform_of(const Pose& pose) {
  const auto& q = pose.rotation_xyzw;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]),
          Eigen::Vector3d(pose.translation_mm[0], pose.translation_mm[1], pose.translation_mm[2])};
}

}  // namespace

StatusTally explain_take(const Rig& rig, const TakeFrames& take, const AuSolverOptions& options,
                         const std::function<void(const ExplainedFrame&)>& sink) {
  AuSolver solver(rig, options);
  try {
    solver.use_marker_set(take.markers);
  } catch (const UserError& error) {
    throw UserError(take.place + ": " + error.what());
  }
  const std::vector<int> index = index_map(take.markers.names, rig.marker_names);
  const auto markers = static_cast<Eigen::Index>(rig.marker_count());
  const auto aus = static_cast<Eigen::Index>(rig.au_count());
  ExplainedFrame out;
  out.x.resize(aus);
  out.observed.resize(rig.au_count());
  out.measured.resize(markers);
  out.weight.resize(markers);
  StatusTally tally{};
  AuFrame solved;
  std::int64_t last_ns = 0;
  bool is_first = true;
  for (std::size_t t = 0; t < take.frames.size(); ++t) {
    const MarkerFrame& frame = take.frames[t];
    RISORIUS_CHECK(solver.push(frame) && solver.pop(solved));
    const double step_s = static_cast<double>(difference_ns(frame.header.capture_time_ns, last_ns)) * 1e-9;
    out.share_of_time = is_first ? 0 : std::clamp(step_s, 0.0, kLongestStep_s);
    is_first = false;
    last_ns = frame.header.capture_time_ns;
    ++tally[static_cast<std::size_t>(solved.status)];
    if (solved.status != SolverStatus::kConverged) continue;
    out.index = t;
    out.world_from_head = transform_of(solved.world_from_head);
    const RigidTransform head_from_world = out.world_from_head.inverse();
    out.displacement_mm = Eigen::Matrix3Xd::Zero(3, markers);
    out.residual_mm = Eigen::Matrix3Xd::Zero(3, markers);
    for (Eigen::Index i = 0; i < aus; ++i) {
      out.x[i] = solved.intensity[static_cast<std::size_t>(i)];
      out.observed[static_cast<std::size_t>(i)] = solved.state[static_cast<std::size_t>(i)] == AuState::kObserved;
    }
    for (Eigen::Index m = 0; m < markers; ++m) {
      const int at = index[static_cast<std::size_t>(m)];
      const bool is_measured = at >= 0 && frame.state[static_cast<std::size_t>(at)] == MarkerState::kMeasured;
      out.measured[m] = is_measured ? 1 : 0;
      out.weight[m] = is_measured ? solver.marker_weights()[m] : 0;
      if (!is_measured) continue;
      const Position& p = frame.position_mm[static_cast<std::size_t>(at)];
      out.displacement_mm.col(m) = head_from_world * Eigen::Vector3d(p.x, p.y, p.z) - rig.neutral_mm.col(m);
      out.residual_mm.col(m) = out.displacement_mm.col(m);
      for (Eigen::Index i = 0; i < aus; ++i) {
        out.residual_mm.col(m) -= out.x[i] * rig.aus[static_cast<std::size_t>(i)].displacement_mm.col(m);
      }
    }
    sink(out);
  }
  return tally;
}

}  // namespace risorius
