#include "replay/performer/au_moves.h"

#include <algorithm>
#include <utility>

namespace risorius {

double AuMove::share_at(double time_s) const noexcept {
  const double u = (time_s - begin_s) / duration_s;
  if (!(u > 0)) return 0;
  if (u >= 1) return 1;
  const double w = u / (u + skew * (1 - u));
  return w * w * w * (w * (6 * w - 15) + 10);
}

AuMoveTrack::AuMoveTrack(std::vector<AuMove> moves, std::size_t au_count)
    : moves_(std::move(moves)), done_(au_count, 0) {
  std::stable_sort(moves_.begin(), moves_.end(),
                   [](const AuMove& a, const AuMove& b) { return a.begin_s < b.begin_s; });
  running_.reserve(moves_.size());
}

void AuMoveTrack::values_at(double time_s, std::span<double> values) noexcept {
  for (; next_ < moves_.size() && moves_[next_].begin_s < time_s; ++next_)
    running_.push_back(static_cast<std::uint32_t>(next_));
  std::size_t kept = 0;
  for (const std::uint32_t index : running_) {
    const AuMove& move = moves_[index];
    if (time_s >= move.begin_s + move.duration_s) {
      done_[move.au] += move.change;
    } else {
      running_[kept++] = index;
    }
  }
  running_.resize(kept);
  std::copy(done_.begin(), done_.end(), values.begin());
  for (const std::uint32_t index : running_)
    values[moves_[index].au] += moves_[index].change * moves_[index].share_at(time_s);
}

void AuMoveTrack::rewind() noexcept {
  std::fill(done_.begin(), done_.end(), 0.0);
  running_.clear();
  next_ = 0;
}

}  // namespace risorius
