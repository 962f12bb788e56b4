#include "capture/repair/take_rehearsal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace risorius {
namespace {

constexpr double kShortestS = 1.0 / 60;
constexpr std::size_t kSpreadPlaces = 64;
/// Below this, markers are equally still.
constexpr double kStillMm2 = 0.01;
/// From here on a gap is one of a region.
constexpr double kMostlyUnheard = 0.4;
/// Of the noise found, which is an upper bound: quick motion is in it, too.
constexpr double kNoiseShare = 0.75;
/// Of what errors against noisy measurements are, this much at least is the fill's own.
constexpr double kLeastOwnShare = 0.15;

}  // namespace

/// Of places spread over the take, those that are most nearly as lively as the gap: in a face at rest every fill is
/// right.
std::vector<std::size_t> TakeRehearsal::places_for(const Gap& gap, std::size_t count) const {
  std::vector<std::size_t> begins;
  std::size_t seen_in_a_row = 0;
  for (std::size_t f = 0; f < take_.frames; ++f) {
    seen_in_a_row = take_.measured[take_.at(f, gap.marker)] ? seen_in_a_row + 1 : 0;
    if (seen_in_a_row >= gap.length() + 2) begins.push_back(f - gap.length());
  }
  if (begins.size() <= count) return begins;
  const auto level = [&](std::size_t begin) { return std::log(regression_.liveliness(gap, begin) + kStillMm2); };
  const double own = level(gap.begin), turn = std::numbers::phi * static_cast<double>(gap.marker + gap.begin);
  const std::size_t spread = std::min(begins.size(), kSpreadPlaces);
  std::vector<std::pair<double, std::size_t>> unlike;  // by how much, place
  for (std::size_t k = 0; k < spread; ++k) {
    const double at = turn + static_cast<double>(k) / static_cast<double>(spread);
    const std::size_t place =
        begins[static_cast<std::size_t>((at - std::floor(at)) * static_cast<double>(begins.size()))];
    unlike.emplace_back(std::abs(level(place) - own), place);
  }
  std::ranges::sort(unlike);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(count, unlike.size()); ++k) chosen.push_back(unlike[k].second);
  return chosen;
}

std::size_t TakeRehearsal::kind_of(const Gap& gap) const {
  const double length_s = take_.time_s[gap.end - 1] - take_.time_s[gap.begin] + kShortestS;
  const double octave = std::clamp(std::ceil(std::log2(length_s / kShortestS)), 0.0, kOctaves - 1.0);
  return static_cast<std::size_t>(octave) + (regression_.unheard(gap) > kMostlyUnheard ? kOctaves : 0);
}

/// From the sample before to the one behind; at an end of the take, of the one that there is.
Eigen::Vector3d TakeRehearsal::straight_mm(const Gap& gap, std::size_t frame) const {
  const auto at = [&](std::size_t f) -> const Eigen::Vector3d& { return take_.position_mm[take_.at(f, gap.marker)]; };
  if (gap.begin == 0) return at(gap.end);
  if (gap.end == take_.frames) return at(gap.begin - 1);
  const double span_s = take_.time_s[gap.end] - take_.time_s[gap.begin - 1];
  const double share = span_s > 0 ? (take_.time_s[frame] - take_.time_s[gap.begin - 1]) / span_s : 0.5;
  return (1 - share) * at(gap.begin - 1) + share * at(gap.end);
}

void TakeRehearsal::practise(const Gap& gap, const GapChoice& choice, std::size_t places) {
  const std::size_t kind = kind_of(gap);
  const double noise_mm = regression_.noise_mm(gap.marker);
  for (const std::size_t begin : places_for(gap, places)) {
    rehearsed_.push_back({kind,
                          {gap.marker, begin, begin + gap.length()},
                          regression_.fill_at(gap, begin, choice),
                          noise_mm * noise_mm});
  }
}

void TakeRehearsal::conclude() {
  trust_.fill(FillTrust());
  for (const bool is_weighed : {false, true}) {
    for (const Rehearsed& r : rehearsed_) {
      FillTrust& trust = trust_[r.kind];
      const double weight = trust.weight(), share = 1 / static_cast<double>(r.gap.length());
      for (std::size_t f = r.gap.begin; f < r.gap.end; ++f) {
        const auto column = static_cast<Eigen::Index>(f - r.gap.begin);
        const Eigen::Vector3d straight = straight_mm(r.gap, f);
        const Eigen::Vector3d moved = r.fill.position_mm.col(column) - straight;
        const Eigen::Vector3d right = take_.position_mm[take_.at(f, r.gap.marker)] - straight;
        const double variance_mm2 = r.fill.variance_mm2[column] + r.noise_mm2;
        if (is_weighed) {
          trust.note_error(share, right - weight * moved, variance_mm2);
        } else {
          trust.note_move(share, moved, right, variance_mm2);
        }
      }
    }
  }
  rehearsed_.clear();
}

void TakeRehearsal::weigh(const Gap& gap, GapRegression::Fill& fill) const {
  const FillTrust& trust = trust_[kind_of(gap)];
  const double weight = trust.weight(), scale = trust.scale();
  const double noise_mm = regression_.noise_mm(gap.marker), noise_mm2 = noise_mm * noise_mm;
  for (std::size_t f = gap.begin; f < gap.end; ++f) {
    const auto column = static_cast<Eigen::Index>(f - gap.begin);
    const Eigen::Vector3d straight = straight_mm(gap, f);
    fill.position_mm.col(column) = straight + weight * (fill.position_mm.col(column) - straight);
    const double with_noise = scale * (fill.variance_mm2[column] + noise_mm2);
    fill.variance_mm2[column] = std::max(with_noise - kNoiseShare * noise_mm2, kLeastOwnShare * with_noise);
  }
}

}  // namespace risorius
