#include "replay/pipeline/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/rigid_alignment.h"
#include "solve/rigs/marker_rigidity.h"

namespace risorius {
namespace {

constexpr double kLongestStep_s = 0.2;
constexpr double kHistoryStep_s = 1;
constexpr double kLeastDriftSamples = 20;

}  // namespace

SlipWatch::SlipWatch(const Rig& rig, const MarkerSet& set, const SlipWatchOptions& options)
    : rig_(rig), options_(options), set_index_(index_map(set.names, rig.marker_names)) {
  const std::size_t markers = rig.marker_count();
  for (std::size_t m = 0; m < markers; ++m) {
    neutral_mm_.emplace_back(rig.neutral_mm.col(static_cast<Eigen::Index>(m)));
    if (rig.stabiliser_weight[static_cast<Eigen::Index>(m)] > 0) stabilisers_.push_back({.marker = m});
  }
  seen_mm_.assign(markers, Eigen::Vector3d::Zero());
  weight_.assign(markers, 0);
  drift_mm_ = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(markers));
  drift_count_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(markers));
  now_.neutral_mm = std::numeric_limits<double>::quiet_NaN();
}

void SlipWatch::add(const SolvedFrame& frame) {
  const std::int64_t time_ns = frame.markers.header.capture_time_ns;
  if (!has_first_) first_ns_ = last_ns_ = time_ns;
  has_first_ = true;
  const double step_s = std::clamp(static_cast<double>(difference_ns(time_ns, last_ns_)) * 1e-9, 0.0, kLongestStep_s);
  last_ns_ = time_ns;
  now_.time_s = static_cast<double>(difference_ns(time_ns, first_ns_)) * 1e-9;
  for (std::size_t m = 0; m < set_index_.size(); ++m) {
    const int at = set_index_[m];
    weight_[m] = at >= 0 && frame.markers.state[static_cast<std::size_t>(at)] == MarkerState::kMeasured ? 1 : 0;
    if (weight_[m] == 0) continue;
    const Position& p = frame.markers.position_mm[static_cast<std::size_t>(at)];
    seen_mm_[m] = {p.x, p.y, p.z};
  }
  // A frame without a pose is of something else than this face, and says nothing of where its markers stick.
  if (frame.aus.status == SolverStatus::kConverged) {
    follow_stabilisers(frame, step_s);
    follow_neutral(frame, step_s);
  }
  if (history_.empty() || now_.time_s - history_.back().time_s >= kHistoryStep_s) history_.push_back(now_);
}

/// Where each stabiliser is in the frame that most of them agree on, slowly; against where it was at first.
void SlipWatch::follow_stabilisers(const SolvedFrame& frame, double step_s) {
  std::vector<Eigen::Vector3d> seen, rest;
  std::vector<double> weight;
  for (const Stabiliser& s : stabilisers_) {
    seen.push_back(seen_mm_[s.marker]);
    // Where the AUs carry it: a nose that wrinkles slides on the skull for as long as it is held.
    Eigen::Vector3d place = neutral_mm_[s.marker];
    for (std::size_t i = 0; i < rig_.au_count(); ++i) {
      place += frame.aus.intensity[i] * rig_.aus[i].displacement_mm.col(static_cast<Eigen::Index>(s.marker));
    }
    rest.push_back(place);
    weight.push_back(weight_[s.marker]);
  }
  const RigidAlignment head_from_world = align_majority(seen, rest, weight);
  if (!head_from_world.determined) return;
  now_.stabiliser_mm = 0;
  for (std::size_t i = 0; i < stabilisers_.size(); ++i) {
    Stabiliser& s = stabilisers_[i];
    if (weight[i] == 0) continue;
    const Eigen::Vector3d off = head_from_world.to_from * seen[i] - rest[i];
    if (!s.has_place) s.place_mm = off;
    s.has_place = true;
    s.place_mm += std::min(1.0, step_s / options_.memory_s) * (off - s.place_mm);
    if (now_.time_s <= options_.settle_s) {
      s.settled_mm += (off - s.settled_mm) / ++s.settled_count;
      continue;
    }
    const double off_mm = (s.place_mm - s.settled_mm).norm();
    now_.stabiliser_mm = std::max(now_.stabiliser_mm, off_mm);
    note(&s, off_mm, s.off_since_s, s.has_slipped);
  }
}

/// What is left of the markers while the face is at rest.
void SlipWatch::follow_neutral(const SolvedFrame& frame, double step_s) {
  // By what they do together, not by each: AUs that the markers confuse may be on against each other at rest.
  Eigen::Matrix3Xd acted_mm = Eigen::Matrix3Xd::Zero(3, drift_mm_.cols());
  for (std::size_t i = 0; i < rig_.au_count(); ++i) acted_mm += frame.aus.intensity[i] * rig_.aus[i].displacement_mm;
  if (acted_mm.squaredNorm() > options_.rest_mm * options_.rest_mm * static_cast<double>(acted_mm.cols())) return;
  const auto& q = frame.aus.world_from_head.rotation_xyzw;
  const auto& t = frame.aus.world_from_head.translation_mm;
  const RigidTransform head_from_world =
      RigidTransform{Eigen::Quaterniond(q[3], q[0], q[1], q[2]), Eigen::Vector3d(t[0], t[1], t[2])}.inverse();
  const double share = std::min(1.0, step_s / options_.drift_memory_s);
  std::vector<Eigen::Vector3d> drifted = neutral_mm_;
  std::vector<double> weight(neutral_mm_.size(), 0);
  double squares = 0, count = 0;
  for (std::size_t m = 0; m < neutral_mm_.size(); ++m) {
    const auto column = static_cast<Eigen::Index>(m);
    if (weight_[m] > 0) {
      const Eigen::Vector3d off = head_from_world * seen_mm_[m] - neutral_mm_[m];
      drift_mm_.col(column) += std::max(share, 1 / ++drift_count_[column]) * (off - drift_mm_.col(column));
    }
    if (drift_count_[column] < kLeastDriftSamples) continue;
    drifted[m] += drift_mm_.col(column);
    weight[m] = rig_.stabiliser_weight[column] > 0 ? 0 : 1;
    squares += drift_mm_.col(column).squaredNorm();
    ++count;
  }
  if (count < 4) return;
  now_.neutral_mm = std::sqrt(squares / count);
  const RigidAlignment face = align_majority(neutral_mm_, drifted, weight);
  if (!face.determined) return;
  double moved = 0;
  for (std::size_t m = 0; m < neutral_mm_.size(); ++m) {
    if (weight[m] > 0) moved = std::max(moved, (face.to_from * neutral_mm_[m] - neutral_mm_[m]).norm());
  }
  now_.band_mm = moved;
  if (now_.time_s <= options_.settle_s || band_settled_mm_ < 0) {
    band_settled_mm_ = moved;
    return;
  }
  note(nullptr, moved - band_settled_mm_, band_off_since_s_, band_has_slipped_);
}

void SlipWatch::note(Stabiliser* stabiliser, double off_mm, double& off_since_s, bool& has_slipped) {
  if (off_mm < options_.slip_mm) {
    off_since_s = -1;
    return;
  }
  if (off_since_s < 0) off_since_s = now_.time_s;
  if (has_slipped || now_.time_s - off_since_s < options_.lasting_s) return;
  has_slipped = true;
  slips_.push_back({stabiliser != nullptr ? rig_.marker_names[stabiliser->marker] : "", off_since_s, off_mm});
}

}  // namespace risorius
