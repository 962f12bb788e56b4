// How intensities move: as a sum of smooth steps, the submovements of motor control (Flash & Hogan 1985; Flash & Henis
// 1991). A new step may begin before the last one has ended; the sum stays smooth, which is what makes neighbouring
// speech targets run into each other. An action is a step up and a step down; an overshoot is a step too far and one
// back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace risorius {

/// One step of one AU: from nothing to `change`, a minimum-jerk curve over warped time.
struct AuMove {
  std::uint32_t au = 0;  ///< index into the channels
  double begin_s = 0, duration_s = 0;
  double change = 0;
  double skew = 1;  ///< 0.3 to 3: half of the (warped) way is done at skew / (1 + skew) of the time; 1 is symmetric

  /// 0 before, 1 after; twice differentiable.
  double share_at(double time_s) const noexcept;
};

/// Plays moves forwards in time. Allocates in the constructor only.
class AuMoveTrack {
 public:
  AuMoveTrack() = default;
  /// Sorts the moves by their begin.
  AuMoveTrack(std::vector<AuMove> moves, std::size_t au_count);

  /// Sets `values`, one per AU: the sum of all moves until then. Times must not decrease until rewind().
  void values_at(double time_s, std::span<double> values) noexcept;
  void rewind() noexcept;
  const std::vector<AuMove>& moves() const noexcept { return moves_; }

 private:
  std::vector<AuMove> moves_;
  std::vector<double> done_;            ///< per AU, the sum of the moves that are over
  std::vector<std::uint32_t> running_;  ///< moves begun and not over
  std::size_t next_ = 0;
};

}  // namespace risorius
