#include "capture/repair/fill_rehearsal.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace risorius {
namespace {

/// What is believed at first of a gap's variance, in units of the stated one: times kUnlearnt at the start, and by this
/// much more in the first second. Set on the jaw and eyebrows takes.
constexpr double kUnlearnt = 1.2, kUnlearntGrowth = 7, kUnlearntPower = 0.8;
constexpr double kFirstAfterS = 0.5;
/// Of the rehearsed gaps, one after the other. Each of them rehearses all shorter ones, too.
constexpr std::array kLengthS{0.27, 2.13, 0.27, 1.07};
/// One marker in so many is hidden, and never so many that the others could not speak for it.
constexpr std::size_t kMarkersPerHidden = 12;
constexpr std::size_t kLeastShown = 6;
/// Of the noise found, which is an upper bound: quick motion is in it, too.
constexpr double kNoiseShare = 0.75;
/// Of what errors against noisy measurements are, this much at least is the fill's own.
constexpr double kLeastOwnShare = 0.15;
constexpr double kTiny = 1e-9;

double believed(double gap_s) noexcept { return kUnlearnt + kUnlearntGrowth * std::pow(gap_s, kUnlearntPower); }

}  // namespace

FillRehearsal::FillRehearsal(MarkerCovarianceOptions options) : covariance_(options), memory_s_(options.memory_s) {
  reset_books();
}

void FillRehearsal::remap(const std::vector<int>& old_index) {
  covariance_.remap(old_index);
  noise_.resize(old_index.size());
  const std::size_t count = old_index.size();
  position_head_mm_.assign(count, Eigen::Vector3d::Zero());
  measured_.assign(count, 0);
  shown_.assign(count, 0);
  hidden_count_ = next_count_ = next_marker_ = 0;
  since_tick_s_ = gap_s_ = 0;
  ends_s_ = kFirstAfterS;
  stride_ = std::max<std::size_t>(1, 5 * count / 8);
  while (std::gcd(stride_, count) > 1) ++stride_;
}

void FillRehearsal::reset() noexcept {
  covariance_.reset();
  noise_.reset();
  reset_books();
}

FillTrust FillRehearsal::belief(std::size_t c) noexcept {
  return FillTrust(std::exp2(2.0 * static_cast<double>(c % kMoves) - 2));
}

void FillRehearsal::reset_books() noexcept {
  for (std::size_t c = 0; c < cells_.size(); ++c) cells_[c] = belief(c);
  hidden_count_ = next_count_ = next_marker_ = next_length_ = 0;
  since_tick_s_ = gap_s_ = 0;
  ends_s_ = kFirstAfterS;
}

/// What was found gives way to the belief.
void FillRehearsal::forget(double seconds) noexcept {
  const double gone = 1 - std::exp(-seconds / memory_s_);
  for (std::size_t c = 0; c < cells_.size(); ++c) cells_[c].give_way(belief(c), gone);
}

void FillRehearsal::take(const std::vector<Eigen::Vector3d>& position_head_mm,
                         const std::vector<std::uint8_t>& measured) noexcept {
  std::ranges::copy(position_head_mm, position_head_mm_.begin());
  std::ranges::copy(measured, measured_.begin());
}

void FillRehearsal::practise(const FillModel& live, double step_s, bool is_informed) noexcept {
  gap_s_ += step_s;
  if (is_informed) {
    noise_.observe(position_head_mm_, measured_, step_s);
    if (gap_s_ > ends_s_) begin_gap();
    std::ranges::copy(measured_, shown_.begin());
    for (std::size_t k = 0; k < hidden_count_; ++k) shown_[hidden_[k].marker] = 0;
    covariance_.observe(position_head_mm_, shown_);
    take_over_shifts();
    compare(live, step_s);
    const double follow = 1 - std::exp(-step_s / FillModel::kLatelyS);
    for (std::size_t k = 0; k < next_count_; ++k) {
      Actor& actor = next_[k];
      const double rate = actor.is_watched ? follow : 1;
      if (shown_[actor.marker]) actor.stayed_head_mm += rate * (position_head_mm_[actor.marker] - actor.stayed_head_mm);
    }
  }
  since_tick_s_ += step_s;
  if (since_tick_s_ < 0.99 * ResidualMemory::kTickS) return;
  if (is_informed) learn();
  since_tick_s_ = 0;
}

void FillRehearsal::learn() noexcept {
  covariance_.prepare_to_learn();
  watch_next();
  covariance_.learn(since_tick_s_);
  take_over_shifts();
}

/// Of those who will be hidden next; nobody needs the residuals of the others, which cost the most.
void FillRehearsal::watch_next() noexcept {
  for (std::size_t k = 0; k < next_count_; ++k) {
    Actor& actor = next_[k];
    if (shown_[actor.marker]) {
      ResidualMemory::follow(actor.level_mm, covariance_.mean_residual_mm(actor.marker), since_tick_s_,
                             actor.is_watched);
    }
    actor.is_watched = shown_[actor.marker] != 0;
  }
}

void FillRehearsal::take_over_shifts() noexcept {
  if (!covariance_.has_shifted()) return;
  for (std::size_t k = 0; k < hidden_count_; ++k) {
    hidden_[k].level_mm.colwise() += covariance_.shift_mm(hidden_[k].marker);
  }
}

/// Those who were hidden are shown again, and who was watched is from this frame on not.
void FillRehearsal::begin_gap() noexcept {
  const auto measured = static_cast<std::size_t>(std::ranges::count(measured_, 1));
  if (covariance_.has_unlearnt()) watch_next();  // the freshest word
  hidden_count_ = 0;
  for (std::size_t k = 0; k < next_count_ && measured > kLeastShown + hidden_count_; ++k) {
    if (!next_[k].is_watched || !measured_[next_[k].marker]) continue;
    hidden_[hidden_count_] = next_[k];
    hidden_[hidden_count_++].has_truth = true;
  }
  choose_next();
  forget(gap_s_);
  gap_s_ = 0;
  ends_s_ = kLengthS[next_length_++ % kLengthS.size()];
}

/// Everyone has a turn.
void FillRehearsal::choose_next() noexcept {
  const std::size_t count = measured_.size();
  const std::size_t most = std::clamp<std::size_t>(count / kMarkersPerHidden, 1, kMostHidden);
  next_count_ = 0;
  for (std::size_t k = 0; k < count && next_count_ < most; ++k) {
    next_marker_ = (next_marker_ + stride_) % count;
    const auto is_it = [this](const Actor& actor) { return actor.marker == next_marker_; };
    const auto hidden = hidden_.begin() + static_cast<std::ptrdiff_t>(hidden_count_);
    if (measured_[next_marker_] && std::none_of(hidden_.begin(), hidden, is_it)) {
      next_[next_count_] = Actor{};
      next_[next_count_++].marker = next_marker_;
    }
  }
}

void FillRehearsal::compare(const FillModel& live, double step_s) noexcept {
  const double gap_s = gap_s_ + step_s;  // since the marker was shown last
  for (std::size_t k = 0; k < hidden_count_; ++k) {
    Actor& actor = hidden_[k];
    const std::size_t i = actor.marker;
    actor.has_truth = actor.has_truth && measured_[i];
    if (!actor.has_truth) continue;
    const auto forecast = live.residuals().forecast_from(actor.level_mm, i, gap_s, covariance_.variance_mm2(i));
    const MarkerFill said{covariance_.prediction_mm(i) + forecast.residual_mm, forecast.variance_mm2};
    note_error(i, said, actor.stayed_head_mm, gap_s, std::min(1.0, step_s / gap_s));
  }
}

/// A frame counts by its share of the octave: so each gap counts once for each.
void FillRehearsal::note_error(std::size_t i, const MarkerFill& said, const Eigen::Vector3d& stayed_head_mm,
                               double gap_s, double frame) noexcept {
  const double unit = believed(gap_s) * said.variance_mm2 + kTiny;
  const MarkerFill fill = weigh(i, said, stayed_head_mm, gap_s);
  const Eigen::Vector3d away = said.position_head_mm - stayed_head_mm;
  const Eigen::Vector3d error = position_head_mm_[i] - fill.position_head_mm;
  const Eigen::Vector3d right = position_head_mm_[i] - stayed_head_mm;
  const Place place = place_of(gap_s, away.squaredNorm() / (3 * unit));
  for (std::size_t c = 0; c < 4; ++c) {
    cells_[place.cell[c]].note_move(frame * place.share[c], away, right, unit);
    cells_[place.cell[c]].note_error(frame * place.share[c], error, unit);
  }
}

FillRehearsal::Place FillRehearsal::place_of(double gap_s, double move) noexcept {
  const double octave = std::clamp(std::log2(std::max(gap_s, kTiny) / ResidualMemory::kTickS), 0.0, kOctaves - 1.0);
  const double size = std::clamp(std::log2(std::max(move, kTiny)) / 2 + 1, 0.0, kMoves - 1.0);
  const std::size_t o = std::min(static_cast<std::size_t>(octave), kOctaves - 2);
  const std::size_t s = std::min(static_cast<std::size_t>(size), kMoves - 2);
  const double p = octave - static_cast<double>(o), q = size - static_cast<double>(s);
  const std::size_t c = o * kMoves + s;
  return {{c, c + 1, c + kMoves, c + kMoves + 1}, {(1 - p) * (1 - q), (1 - p) * q, p * (1 - q), p * q}};
}

MarkerFill FillRehearsal::weigh(std::size_t i, const MarkerFill& model, const Eigen::Vector3d& stayed_head_mm,
                                double gap_s) const noexcept {
  const double unit = believed(gap_s) * model.variance_mm2 + kTiny;
  const Eigen::Vector3d away = model.position_head_mm - stayed_head_mm;
  const Place place = place_of(gap_s, away.squaredNorm() / (3 * unit));
  double weighed = 0, scaled = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    weighed += place.share[c] * cells_[place.cell[c]].weight();
    scaled += place.share[c] * cells_[place.cell[c]].scale();
  }
  // What was measured when the marker came back had its noise, too, and the fill has not.
  const double with_noise = scaled * unit;
  return {stayed_head_mm + weighed * away,
          std::max(with_noise - kNoiseShare * noise_.variance_mm2(i), kLeastOwnShare * with_noise)};
}

}  // namespace risorius
