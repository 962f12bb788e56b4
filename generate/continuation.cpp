#include "generate/continuation.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kLongestHorizon_ms = 2000;

std::int64_t checked_interval_ns(double max_rate_hz) {
  if (!(max_rate_hz >= 1 && max_rate_hz <= 1000)) {
    throw std::invalid_argument(fmt::format("ContinuerOptions.max_rate_hz {} is not in [1, 1000]", max_rate_hz));
  }
  return std::llround(1e9 / max_rate_hz);
}

std::vector<std::int64_t> checked_horizons_ns(const std::vector<double>& horizons_ms) {
  if (horizons_ms.empty() || horizons_ms.size() > kMaxContinuationSteps) {
    throw std::invalid_argument(fmt::format("ContinuerOptions.horizons_ms has {} entries, allowed are 1 to {}",
                                            horizons_ms.size(), kMaxContinuationSteps));
  }
  std::vector<std::int64_t> result;
  double previous = 0;
  for (const double horizon : horizons_ms) {
    if (!(horizon > previous && horizon <= kLongestHorizon_ms)) {
      throw std::invalid_argument(
          fmt::format("ContinuerOptions.horizons_ms: {} after {}, allowed are ascending values in (0, {}]", horizon,
                      previous, kLongestHorizon_ms));
    }
    result.push_back(std::llround(horizon * 1e6));
    previous = horizon;
  }
  return result;
}

}  // namespace

Continuer::Continuer(std::unique_ptr<ContinuationModel> model, const ContinuerOptions& options)
    : model_(std::move(model)),
      interval_ns_(checked_interval_ns(options.max_rate_hz)),
      ahead_ns_(checked_horizons_ns(options.horizons_ms)) {
  if (model_ == nullptr) throw std::invalid_argument("Continuer needs a model, none was given");
}

bool Continuer::process(const AuFrame& frame, Continuation& continuation) noexcept {
  if (frame.kind == AuFrameKind::kPredicted || frame.count > kMaxAus || !is_due(frame)) return false;
  model_->observe(frame);
  continuation = Continuation{};
  continuation.header = frame.header;
  continuation.au_count = frame.count;
  continuation.step_count = static_cast<std::uint32_t>(ahead_ns_.size());
  for (std::size_t step = 0; step < ahead_ns_.size(); ++step) continuation.ahead_ns[step] = ahead_ns_[step];
  model_->predict(continuation);
  return true;
}

/// Times are due on a grid, so that 60 out of 125 frames/s are 60 and not 41; a quarter of an interval early counts as
/// due, since capture times are rounded and jitter.
bool Continuer::is_due(const AuFrame& frame) noexcept {
  const bool has_aus = frame.status == SolverStatus::kConverged || frame.status == SolverStatus::kIterationLimit ||
                       frame.status == SolverStatus::kMapped;
  if (!has_aus) return false;
  const std::int64_t time_ns = frame.header.capture_time_ns;
  if (started_ && time_ns == last_time_ns_ && frame.header.set_id == set_id_) return false;
  if (!started_ || time_ns < last_time_ns_ || frame.header.set_id != set_id_) {
    if (started_) model_->reset();
    started_ = true;
    set_id_ = frame.header.set_id;
    due_ns_ = time_ns;
  }
  last_time_ns_ = time_ns;
  const std::int64_t tolerance_ns = interval_ns_ / 4;
  const std::int64_t late_ns = difference_ns(time_ns, due_ns_);
  if (late_ns < -tolerance_ns) return false;
  // At the end of time itself, all is due.
  due_ns_ = std::min(late_ns > interval_ns_ ? time_ns : due_ns_, INT64_MAX - interval_ns_) + interval_ns_;
  return true;
}

}  // namespace risorius
