#include "replay/pipeline/shape_mapper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/wire/live_link_codec.h"
#include "replay/takes/au_series.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> shape_names() {
  const auto names = live_link_shape_names();
  return {names.begin(), names.end()};
}

JawColumns jaw_of(const std::vector<std::string>& au_names) {
  const bool split = std::ranges::find(au_names, "AU26") != au_names.end();
  return split ? JawColumns::kSplit : JawColumns::kWhole;
}

}  // namespace

ShapeMapper::ShapeMapper(const ArkitTable& table, const Rig& rig)
    : reader_(shape_names(), table, jaw_of(rig.au_names()), false),
      au_set_id_(au_set_id(rig.au_names())),
      readings_(reader_.names().size()),
      last_(rig.au_count(), kNone) {
  for (const auto& au : rig.aus) {
    Column& column = columns_.emplace_back();
    column.upper_bound = au.upper_bound;
    for (const std::size_t reading : columns_for(reader_.names(), au.name)) column.reading[column.count++] = reading;
    if (column.count == 0) not_mapped_.push_back(au.name);
  }
}

void ShapeMapper::reset() noexcept {
  std::ranges::fill(last_, kNone);
  if (neutral_running_) ++neutrals_cancelled_;
  neutral_running_ = false;
}

void ShapeMapper::read_shapes(const ShapeFrame& frame) noexcept {
  for (std::size_t i = 0; i < kFaceShapes; ++i) {
    const auto shape = static_cast<double>(frame.value[i]);
    // Without a neutral nothing is touched, not even what lies a little below 0.
    shapes_[i] = neutrals_completed_ == 0 || std::isnan(shape) ? shape : std::max(0.0, shape - neutral_[i]);
  }
  reader_.read(shapes_, readings_);
}

void ShapeMapper::process(const ShapeFrame& frame, AuFrame& out) noexcept {
  out = AuFrame{};
  out.header = frame.header;
  out.header.set_id = au_set_id_;
  out.kind = AuFrameKind::kMapped;
  out.status = frame.has_face ? SolverStatus::kMapped : SolverStatus::kNoFace;
  out.count = static_cast<std::uint32_t>(columns_.size());
  if (frame.has_face) read_shapes(frame);
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Column& column = columns_[k];
    out.standard_deviation[k] = kNone;
    double sum = 0;
    for (std::size_t i = 0; i < column.count; ++i) sum += readings_[column.reading[i]];
    const bool observed = frame.has_face && column.count > 0 && !std::isnan(sum);
    if (observed) last_[k] = std::min(sum / static_cast<double>(column.count), column.upper_bound);
    if (std::isnan(last_[k])) continue;
    out.state[k] = observed ? AuState::kObserved : AuState::kHeld;
    out.intensity[k] = last_[k];
  }
  // After the frame: a neutral holds from the next one on.
  if (frame.has_face && neutral_running_) add_to_neutral(frame);
}

void ShapeMapper::begin_neutral_capture(std::int64_t duration_ns) noexcept {
  if (neutral_running_) ++neutrals_cancelled_;  // the later request counts
  neutral_running_ = true;
  neutral_duration_ns_ = duration_ns;
  restart_neutral();
}

void ShapeMapper::restart_neutral() noexcept {
  neutral_begin_ns_.reset();
  neutral_sum_.fill(0);
  neutral_count_.fill(0);
}

void ShapeMapper::add_to_neutral(const ShapeFrame& frame) noexcept {
  if (!neutral_begin_ns_) neutral_begin_ns_ = frame.header.capture_time_ns;
  const std::int64_t elapsed_ns = difference_ns(frame.header.capture_time_ns, *neutral_begin_ns_);
  if (elapsed_ns < 0) return restart_neutral();  // the device's clock was set back
  if (elapsed_ns >= neutral_duration_ns_) {
    for (std::size_t i = 0; i < kFaceShapes; ++i)
      neutral_[i] = neutral_count_[i] > 0 ? neutral_sum_[i] / neutral_count_[i] : 0;
    neutral_running_ = false;
    ++neutrals_completed_;
    return;
  }
  for (std::size_t i = 0; i < kFaceShapes; ++i) {
    if (std::isnan(frame.value[i])) continue;
    neutral_sum_[i] += static_cast<double>(frame.value[i]);
    ++neutral_count_[i];
  }
}

}  // namespace risorius
