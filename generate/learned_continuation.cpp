#include "generate/learned_continuation.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

#include "capture/errors.h"
#include "generate/weights_reader.h"

namespace risorius {
namespace {

constexpr float kNinety = 1.645F;  ///< of a normal distribution, between -1.645 and 1.645 lie nine of ten
constexpr float kMissed = 0.1F;
constexpr float kLearning = 0.02F;
constexpr float kMostLogFactor = 4;  ///< a factor of 55: a face at rest says little of how far it will go
constexpr float kMoved = 0.1F;       ///< AUs that have not moved by this say nothing about errors
constexpr float kLeastDeviation = 1e-4F;
constexpr float kStillScale = 0.0105F;  ///< of an AU that does not move; the least is 0.01
constexpr std::int64_t kLeastApart_ns = 15'000'000, kLongestInterpolation_ns = 100'000'000;
constexpr std::int64_t kLongestGapNs = 500'000'000;

void apply_silu(Eigen::Ref<Eigen::ArrayXf> x) noexcept { x *= (1 + (-x).exp()).inverse(); }
std::span<float> span_of(Eigen::ArrayXf& x) noexcept { return {x.data(), static_cast<std::size_t>(x.size())}; }

}  // namespace

LearnedContinuation::LearnedContinuation(const Safetensors& weights, const std::string& place,
                                         const std::vector<std::string>& names, std::vector<double> upper_bound)
    : upper_bound_(std::move(upper_bound)), maker_(names), features_(maker_.allocate()), combination_(names.size()) {
  if (names.empty() || names.size() > kMaxAus || names.size() != upper_bound_.size())
    throw std::invalid_argument(
        fmt::format("LearnedContinuation: {} AUs and {} bounds", names.size(), upper_bound_.size()));
  if (weights.require_metadata(place, "model") != "continuation")
    throw UserError(place, "is a model '" + shown(weights.require_metadata(place, "model")) + "'",
                    "give weights of continuation");
  const WeightsReader reader{weights, place};
  const std::int64_t units = reader.rows("input.weight");
  if (units < 1) throw UserError(place, "has no tensor 'input.weight'", "train it again");
  input_ = reader.dense<float>("input", units, kContinuationWidth);
  first_ = reader.dense<float>("first", units, units);
  second_ = reader.dense<float>("second", units, units);
  output_ = reader.dense<float>("output", 2 * kHorizons, units);
  hidden_.setZero(units);
  more_.setZero(units);
  out_.setZero(2 * kHorizons);
  now_ = empty();
  made_.assign(kRemembered, now_);
  x_.assign(names.size(), 0);
  before_ = x_;
  least_.assign(names.size(), std::numeric_limits<float>::infinity());
  most_.assign(names.size(), -std::numeric_limits<float>::infinity());
  observed_.assign(names.size(), false);
  was_observed_ = observed_;
}

LearnedContinuation::Prediction LearnedContinuation::empty() const {
  const auto aus = static_cast<Eigen::Index>(upper_bound_.size());
  Prediction prediction;
  prediction.mean = prediction.deviation = Table::Zero(kHorizons, aus);
  prediction.terms.fill(Terms::Zero(ContinuationCombination::kTerms, aus));
  prediction.value = prediction.scale = Eigen::ArrayXf::Zero(aus);
  return prediction;
}

void LearnedContinuation::reset() noexcept {
  maker_.reset();
  made_count_ = made_next_ = 0;
  started_ = false;
}

void LearnedContinuation::observe(const AuFrame& frame) noexcept {
  // What lies longer ago than the network looks back says nothing of the motion now.
  if (started_ && difference_ns(frame.header.capture_time_ns, time_ns_) > kLongestGapNs) reset();
  std::copy(x_.begin(), x_.end(), before_.begin());
  was_observed_.swap(observed_);
  for (std::size_t au = 0; au < x_.size(); ++au) {
    observed_[au] = au < frame.count && frame.state[au] == AuState::kObserved && std::isfinite(frame.intensity[au]);
    if (au < frame.count && std::isfinite(frame.intensity[au])) x_[au] = static_cast<float>(frame.intensity[au]);
    if (!observed_[au]) continue;
    least_[au] = std::min(least_[au], x_[au]);
    most_[au] = std::max(most_[au], x_[au]);
  }
  const std::int64_t before_ns = time_ns_;
  time_ns_ = frame.header.capture_time_ns;
  if (started_ && difference_ns(time_ns_, before_ns) <= kLongestInterpolation_ns) learn(time_ns_, before_ns);
  started_ = true;
  maker_.observe(time_ns_, x_);
  run();
  remember();
}

/// The network over all AUs, from the frame observed last.
void LearnedContinuation::run() noexcept {
  maker_.make(features_);
  for (Eigen::Index au = 0; au < features_.value.size(); ++au) {
    input_.process({features_.inputs.row(au).data(), static_cast<std::size_t>(kContinuationWidth)}, span_of(hidden_));
    apply_silu(hidden_);
    first_.process(span_of(hidden_), span_of(more_));
    apply_silu(more_);
    hidden_ += more_;
    second_.process(span_of(hidden_), span_of(more_));
    apply_silu(more_);
    hidden_ += more_;
    output_.process(span_of(hidden_), span_of(out_));
    const float scale = features_.scale(au);
    for (std::size_t h = 0; h < kHorizons; ++h) {
      const auto i = static_cast<Eigen::Index>(h);
      const ContinuationCombination::Terms terms = ContinuationCombination::terms(features_, au, h, scale * out_(i));
      now_.terms[h].col(au) = terms;
      now_.mean(i, au) = features_.value(au) + combination_.change(h, au, terms);
      now_.deviation(i, au) = std::max(
          scale * std::exp(std::clamp(out_(i + static_cast<Eigen::Index>(kHorizons)), -8.0F, 4.0F)), kLeastDeviation);
      now_.mean(i, au) =
          std::clamp(now_.mean(i, au), 0.0F, static_cast<float>(upper_bound_[static_cast<std::size_t>(au)]));
    }
  }
  now_.value = features_.value.array();
  now_.scale = features_.scale.array();
  now_.time_ns = time_ns_;
}

void LearnedContinuation::remember() noexcept {
  if (made_count_ > 0 && time_ns_ - made_[(made_next_ + kRemembered - 1) % kRemembered].time_ns < kLeastApart_ns)
    return;
  Prediction& slot = made_[made_next_];
  slot = now_;
  made_next_ = (made_next_ + 1) % kRemembered;
  made_count_ = std::min(made_count_ + 1, kRemembered);
}

/// Scores every remembered prediction whose time lies between the last two frames.
void LearnedContinuation::learn(std::int64_t time_ns, std::int64_t before_ns) noexcept {
  combination_.forget(static_cast<double>(time_ns - before_ns) * 1e-9);
  for (std::size_t back = 0; back < made_count_; ++back) {
    const Prediction& made = made_[(made_next_ + kRemembered - 1 - back) % kRemembered];
    for (std::size_t h = 0; h < kHorizons; ++h) {
      const std::int64_t target_ns = made.time_ns + static_cast<std::int64_t>(kContinuationHorizonsMs[h] * 1e6);
      if (target_ns <= before_ns || target_ns > time_ns) continue;
      score(made, h, static_cast<float>(target_ns - before_ns) / static_cast<float>(time_ns - before_ns));
    }
  }
  combination_.solve();
}

void LearnedContinuation::score(const Prediction& made, std::size_t horizon, float share) noexcept {
  const auto h = static_cast<Eigen::Index>(horizon);
  const float factor = std::exp(log_factor_[horizon]);
  int scored = 0, missed = 0;
  for (std::size_t au = 0; au < x_.size(); ++au) {
    if (!observed_[au] || !was_observed_[au]) continue;
    const auto column = static_cast<Eigen::Index>(au);
    const float actual = before_[au] + share * (x_[au] - before_[au]);
    if (made.scale(column) > kStillScale)
      combination_.learn(horizon, column, made.terms[horizon].col(column), actual - made.value(column),
                         made.scale(column));
    if (most_[au] - least_[au] < kMoved) continue;
    ++scored;
    if (std::abs(actual - made.mean(h, column)) > kNinety * factor * made.deviation(h, column)) ++missed;
  }
  if (scored == 0) return;
  const float excess = static_cast<float>(missed) / static_cast<float>(scored) - kMissed;
  log_factor_[horizon] = std::clamp(log_factor_[horizon] + kLearning * excess, -kMostLogFactor, kMostLogFactor);
}

void LearnedContinuation::predict(Continuation& continuation) noexcept {
  const std::size_t aus = std::min<std::size_t>(continuation.au_count, kMaxAus),
                    steps = std::min<std::size_t>(continuation.step_count, kMaxContinuationSteps);
  for (std::size_t step = 0; step < steps; ++step) {
    const double ahead_ms = static_cast<double>(continuation.ahead_ns[step]) * 1e-6;
    // Between which of the network's horizons; 0 is the present.
    std::size_t after = 0;
    while (after + 1 < kHorizons && kContinuationHorizonsMs[after] < ahead_ms) ++after;
    const double from_ms = after == 0 ? 0 : kContinuationHorizonsMs[after - 1];
    const auto share =
        static_cast<float>(std::clamp((ahead_ms - from_ms) / (kContinuationHorizonsMs[after] - from_ms), 0.0, 1.0));
    for (std::size_t au = 0; au < aus; ++au) {
      float& mean = continuation.intensity[step][au] = 0;
      float& deviation = continuation.standard_deviation[step][au] = std::numeric_limits<float>::quiet_NaN();
      if (!started_ || au >= x_.size()) continue;
      mean = std::clamp(x_[au], 0.0F, static_cast<float>(upper_bound_[au]));
      if (!observed_[au]) continue;
      const auto column = static_cast<Eigen::Index>(au);
      const auto to = static_cast<Eigen::Index>(after);
      const float from_mean = after == 0 ? mean : now_.mean(to - 1, column),
                  from_deviation = after == 0 ? 0 : std::exp(log_factor_[after - 1]) * now_.deviation(to - 1, column);
      mean = from_mean + share * (now_.mean(to, column) - from_mean);
      deviation = std::max(
          kLeastDeviation,
          from_deviation + share * (std::exp(log_factor_[after]) * now_.deviation(to, column) - from_deviation));
    }
  }
}

}  // namespace risorius
