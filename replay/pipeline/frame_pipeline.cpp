#include "replay/pipeline/frame_pipeline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "capture/check.h"
#include "capture/errors.h"
#include "replay/pipeline/rig_neutral.h"
#include "solve/rigs/rig_motion.h"

namespace risorius {
namespace {

/// A marker enters the new neutral if it was seen in at least this share of the averaged frames.
constexpr double kNeutralPresence = 0.5;
/// In the rig's source, before what is said of it.
constexpr const char* kNeutralWords = "; neutral captured live: ";

std::vector<double> upper_bounds_of(const Rig& rig) {
  std::vector<double> bounds;
  for (const auto& au : rig.aus) bounds.push_back(au.upper_bound);
  return bounds;
}

/// What fills gaps is told how this face moves.
GapFillerOptions fill_options_of(const PipelineOptions& options, const Rig& rig) {
  GapFillerOptions fill = options.fill;
  fill.known_motion = motion_of(rig);
  return fill;
}

}  // namespace

FramePipeline::FramePipeline(const PipelineOptions& options, Rig rig)
    : rig_(std::move(rig)),
      despiker_(options.despike),
      filler_(fill_options_of(options, rig_)),
      solver_(rig_, options.solve),
      continuer_(make_continuation_model(options.continuation_model, rig_.au_names(), upper_bounds_of(rig_)),
                 options.continuation),
      neutral_sum_mm_(3, static_cast<Eigen::Index>(rig_.marker_count())),
      neutral_squares_mm2_(static_cast<Eigen::Index>(rig_.marker_count())),
      neutral_count_(static_cast<Eigen::Index>(rig_.marker_count())) {}

void FramePipeline::use_marker_set(const MarkerSet& set) {
  if (const auto problems = problems_of(set); !problems.empty()) throw UserError("marker set", problems.front(), "");
  set_id_ = set.id;
  set_count_ = static_cast<std::uint32_t>(set.names.size());
  despiker_.use_marker_set(set);
  filler_.use_marker_set(set);
  set_index_of_rig_marker_ = index_map(set.names, rig_.marker_names);
  cancel_neutral();
  rig_problem_.clear();
  try {
    solver_.use_marker_set(set);
  } catch (const UserError& error) {
    rig_problem_ = error.what();
  }
}

bool FramePipeline::push(const MarkerFrame& frame) noexcept {
  if (frame.header.set_id == set_id_ && frame.count == set_count_) return despiker_.push(frame);
  refused_.add();
  return true;
}

bool FramePipeline::pop(SolvedFrame& out) noexcept {
  while (!filler_.pop(out.markers)) {
    if (!despiker_.pop(between_)) return false;
    RISORIUS_CHECK(filler_.push(between_, despiker_));
  }
  note(PipelineStep::kCleaned);
  const bool looked_at = rig_problem_.empty() && solver_.push(out.markers) && solver_.pop(out.aus);
  if (!looked_at) {
    out.aus = AuFrame{};
    out.aus.header = out.markers.header;
    out.aus.header.set_id = solver_.au_set_id();
    out.aus.count = static_cast<std::uint32_t>(rig_.au_count());
  }
  note(PipelineStep::kSolved);
  if (neutral_.running) add_to_neutral(out);
  return true;
}

void FramePipeline::flush() noexcept {
  despiker_.flush();
  while (despiker_.pop(between_)) RISORIUS_CHECK(filler_.push(between_, despiker_));
  filler_.flush();
}

void FramePipeline::reset() noexcept {
  cancel_neutral();  // another take is perhaps another actor
  despiker_.reset();
  filler_.reset();
  solver_.flush();
}

void FramePipeline::cancel_neutral() noexcept {
  if (neutral_.running) ++neutral_.cancelled;
  neutral_.running = false;
}

void FramePipeline::begin_neutral_capture(std::int64_t duration_ns) noexcept {
  cancel_neutral();  // the later request counts
  neutral_.running = true;
  neutral_duration_ns_ = duration_ns;
  restart_neutral();
}

void FramePipeline::restart_neutral() noexcept {
  neutral_begin_ns_.reset();
  neutral_.frames = 0;
  neutral_sum_mm_.setZero();
  neutral_squares_mm2_.setZero();
  neutral_count_.setZero();
}

void FramePipeline::add_to_neutral(const SolvedFrame& frame) {
  if (frame.aus.status != SolverStatus::kConverged) return;
  if (!neutral_begin_ns_) neutral_begin_ns_ = frame.markers.header.capture_time_ns;
  const std::int64_t elapsed_ns = difference_ns(frame.markers.header.capture_time_ns, *neutral_begin_ns_);
  if (elapsed_ns < 0) return restart_neutral();  // the tracker's clock was set back
  if (elapsed_ns >= neutral_duration_ns_) {
    finish_neutral();
    return;
  }
  const auto& q = frame.aus.world_from_head.rotation_xyzw;
  const auto& t = frame.aus.world_from_head.translation_mm;
  const Eigen::Quaterniond head_from_world_rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).conjugate();
  const Eigen::Vector3d head_in_world(t[0], t[1], t[2]);
  ++neutral_.frames;
  for (std::size_t m = 0; m < set_index_of_rig_marker_.size(); ++m) {
    const int i = set_index_of_rig_marker_[m];
    if (i < 0 || frame.markers.state[static_cast<std::size_t>(i)] != MarkerState::kMeasured) continue;
    const Position& p = frame.markers.position_mm[static_cast<std::size_t>(i)];
    const auto column = static_cast<Eigen::Index>(m);
    const Eigen::Vector3d in_head = head_from_world_rotation * (Eigen::Vector3d(p.x, p.y, p.z) - head_in_world);
    neutral_sum_mm_.col(column) += in_head;
    neutral_squares_mm2_[column] += (in_head - rig_.neutral_mm.col(column)).squaredNorm();
    neutral_count_[column] += 1;
  }
}

void FramePipeline::finish_neutral() {
  neutral_.running = false;
  Rig renewed = rig_;
  double largest_shift_mm = 0, motion_mm2 = 0, markers = 0;
  for (Eigen::Index m = 0; m < neutral_count_.size(); ++m) {
    if (neutral_count_[m] < kNeutralPresence * neutral_.frames) continue;
    const Eigen::Vector3d mean = neutral_sum_mm_.col(m) / neutral_count_[m];
    const double shift_mm2 = (mean - rig_.neutral_mm.col(m)).squaredNorm();
    largest_shift_mm = std::max(largest_shift_mm, std::sqrt(shift_mm2));
    motion_mm2 += std::max(0.0, neutral_squares_mm2_[m] / neutral_count_[m] - shift_mm2);
    ++markers;
    renewed.neutral_mm.col(m) = mean;
  }
  neutral_.motion_mm = markers > 0 ? std::sqrt(motion_mm2 / markers) : 0;
  // No stabilisers in sight or on one line, or a face that spoke: the old neutral stays.
  if (!problems_of(renewed).empty() || neutral_.motion_mm > kLargestMotionMm) {
    ++neutral_.refused;
    return;
  }
  // Of the last neutral only: those before it are gone.
  renewed.source.resize(std::min(renewed.source.size(), renewed.source.find(kNeutralWords)));
  renewed.source +=
      fmt::format("{}{} frames over {:g} s of capture time, markers moved by up to {:.2f} mm", kNeutralWords,
                  neutral_.frames, static_cast<double>(neutral_duration_ns_) * 1e-9, largest_shift_mm);
  solver_.set_neutral(renewed.neutral_mm);
  rig_ = std::move(renewed);
  neutral_.largest_shift_mm = largest_shift_mm;
  ++neutral_.completed;
}

}  // namespace risorius
