#include "capture/repair/head_frame.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/marker_set.h"

namespace risorius {
namespace {

/// Deformation of a marker that nothing is known of yet, and how many samples that belief is worth.
constexpr double kPriorDeformationMm2 = 4.0;
constexpr double kPriorSamples = 30;
/// Below this, markers are equally still: it keeps a few of them from taking over the frame.
constexpr double kFloorMm2 = 0.3 * 0.3;
/// The loss turns at this many standard deviations.
constexpr double kRobustScale = 3.0;
constexpr int kReweightings = 2;
constexpr double kLongestStepS = 1.0;
/// A marker farther from the median of all than so many times the median distance, and that on top, belongs to no face:
/// wide enough for a whole body under the same set.
constexpr double kFarMultiple = 20, kFarMm = 2000;
constexpr std::ptrdiff_t kFewestForFar = 4;

bool finite(Position p) noexcept { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

template <class T>
void remap(std::vector<T>& values, const std::vector<int>& old_index, const T& unknown) {
  std::vector<T> mapped(old_index.size(), unknown);
  for (std::size_t i = 0; i < old_index.size(); ++i) {
    if (old_index[i] >= 0) mapped[i] = values[static_cast<std::size_t>(old_index[i])];
  }
  values = std::move(mapped);
}

}  // namespace

HeadFrame::HeadFrame(HeadFrameOptions options) : options_(std::move(options)) {
  if (!(options_.reference_completeness > 0 && options_.reference_completeness <= 1)) {
    throw UserError("reference_completeness", fmt::format("{} is not in (0, 1]", options_.reference_completeness),
                    "0.7 is the default");
  }
  if (!(options_.memory_s > 0)) {
    throw UserError("memory_s", fmt::format("{} is not > 0", options_.memory_s), "30 is the default");
  }
  for (const auto& [name, weight] : options_.stabilisers) {
    if (!(weight > 0) || !std::isfinite(weight)) {
      throw UserError("stabilisers." + name, fmt::format("weight {} is not a positive number", weight),
                      "leave out markers that do not hold the head still");
    }
  }
}

void HeadFrame::use_names(const std::vector<std::string>& names) {
  const std::vector<int> old_index = index_map(names_, names);
  names_ = names;
  remap(reference_mm_, old_index, Eigen::Vector3d(Eigen::Vector3d::Zero()));
  remap(samples_, old_index, 0.0);
  remap(deformation_mm2_, old_index, kPriorDeformationMm2);
  position_world_mm_.assign(names.size(), Eigen::Vector3d::Zero());
  position_head_mm_.assign(names.size(), Eigen::Vector3d::Zero());
  weight_.assign(names.size(), 0);
  scratch_.reserve(names.size());
  measured_.assign(names.size(), 0);
  has_reference_ = std::count_if(samples_.begin(), samples_.end(), [](double n) { return n > 0; }) >= 3;
  if (!has_reference_) reset();

  given_weight_.clear();
  std::vector<double> given(names.size(), 0);
  int known = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const auto& [name, weight] : options_.stabilisers) {
      if (name == names[i]) given[i] = weight, ++known;
    }
  }
  if (known >= 3) given_weight_ = std::move(given);  // fewer cannot hold a head: learn instead
}

void HeadFrame::reset() noexcept {
  std::fill(samples_.begin(), samples_.end(), 0.0);
  std::fill(deformation_mm2_.begin(), deformation_mm2_.end(), kPriorDeformationMm2);
  has_reference_ = false;
  determined_ = false;
  head_from_world_ = {};
}

bool HeadFrame::process(const MarkerFrame& frame) noexcept {
  RISORIUS_CHECK(frame.count == names_.size());
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const Position p = frame.position_mm[i];
    measured_[i] = frame.state[i] == MarkerState::kMeasured && finite(p);
    if (measured_[i]) position_world_mm_[i] = Eigen::Vector3d(p.x, p.y, p.z);
  }
  leave_out_far_markers();
  determined_ = has_reference_ ? align() : start_reference(frame);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (measured_[i]) position_head_mm_[i] = head_from_world_ * position_world_mm_[i];
  }
  return determined_;
}

void HeadFrame::leave_out_far_markers() noexcept {
  if (std::count(measured_.begin(), measured_.end(), 1) < kFewestForFar) return;
  const auto median = [this](auto value_of) {
    scratch_.clear();
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (measured_[i]) scratch_.push_back(value_of(position_world_mm_[i]));
    }
    const auto middle = scratch_.begin() + static_cast<std::ptrdiff_t>(scratch_.size() / 2);
    std::nth_element(scratch_.begin(), middle, scratch_.end());
    return *middle;
  };
  const Eigen::Vector3d centre(median([](const Eigen::Vector3d& p) { return p.x(); }),
                               median([](const Eigen::Vector3d& p) { return p.y(); }),
                               median([](const Eigen::Vector3d& p) { return p.z(); }));
  const double usual_mm = median([&](const Eigen::Vector3d& p) { return (p - centre).norm(); });
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (measured_[i] && (position_world_mm_[i] - centre).norm() > kFarMultiple * usual_mm + kFarMm) measured_[i] = 0;
  }
}

bool HeadFrame::start_reference(const MarkerFrame& frame) noexcept {
  const auto count = static_cast<double>(std::count(measured_.begin(), measured_.end(), 1));
  if (count < 3 || count < options_.reference_completeness * frame.count) return false;
  head_from_world_ = {};
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (measured_[i]) centre += position_world_mm_[i] / count;
  }
  head_from_world_.translation = -centre;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    weight_[i] = measured_[i];
    if (measured_[i]) reference_mm_[i] = position_world_mm_[i] - centre;
  }
  // Markers on one line would be a reference that leaves every later rotation open.
  if (!align_rigid(position_world_mm_, reference_mm_, weight_).determined) return false;
  for (std::size_t i = 0; i < names_.size(); ++i) samples_[i] = measured_[i];
  has_reference_ = true;
  return true;
}

double HeadFrame::weight_of(std::size_t i) const noexcept {
  if (!measured_[i] || !(samples_[i] > 0)) return 0;
  if (!given_weight_.empty()) return given_weight_[i];
  return 1 / (kFloorMm2 + deformation_mm2_[i]);
}

bool HeadFrame::align() noexcept {
  for (std::size_t i = 0; i < names_.size(); ++i) weight_[i] = weight_of(i);
  RigidAlignment alignment = align_rigid(position_world_mm_, reference_mm_, weight_);
  if (!alignment.determined) return false;
  for (int k = 0; k < kReweightings; ++k) {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (!(weight_[i] > 0)) continue;
      const double squared = (alignment.to_from * position_world_mm_[i] - reference_mm_[i]).squaredNorm();
      const double relative = squared / (kRobustScale * kRobustScale * (kFloorMm2 + deformation_mm2_[i]));
      weight_[i] = weight_of(i) / ((1 + relative) * (1 + relative));
    }
    alignment = align_rigid(position_world_mm_, reference_mm_, weight_);
    if (!alignment.determined) return false;
  }
  head_from_world_ = alignment.to_from;
  return true;
}

void HeadFrame::learn(double step_s, const std::vector<std::uint8_t>& trusted) noexcept {
  if (!determined_) return;
  // After a gap in time one frame must not outweigh, or overshoot, what was learnt before it.
  const double believed_s = std::min(step_s, kLongestStepS);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!measured_[i] || !trusted[i]) continue;
    if (samples_[i] > 0) {
      const double rate = std::max(1 / (samples_[i] + kPriorSamples), believed_s / options_.memory_s);
      const Eigen::Vector3d deviation = position_head_mm_[i] - reference_mm_[i];
      deformation_mm2_[i] += rate * (deviation.squaredNorm() - deformation_mm2_[i]);
      reference_mm_[i] += std::max(1 / (samples_[i] + 1), believed_s / options_.memory_s) * deviation;
    } else {
      reference_mm_[i] = position_head_mm_[i];
    }
    samples_[i] = std::min(samples_[i] + 1, 1e9);
  }
}

}  // namespace risorius
