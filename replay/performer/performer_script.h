// What the synthetic performer plays: AU pulses over time (onset, held apex, offset) for expressions, single actions,
// speech and blinks, written from a seed for the AUs that a rig has. Overlapping pulses of one AU add up softly:
// 1 - prod(1 - v), so intensities stay in [0, 1] and smooth (twice differentiable in time).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace risorius {

/// One action: from 0 to the peak, held, and back, each way a minimum-jerk curve (Flash & Hogan 1985).
struct AuPulse {
  std::uint32_t au = 0;  ///< index into the AU names
  double begin_s = 0, onset_s = 0, hold_s = 0, offset_s = 0;
  double peak = 0;  ///< 0 to 1

  double end_s() const noexcept { return begin_s + onset_s + hold_s + offset_s; }
  double value_at(double time_s) const noexcept;
};

class PerformerScript {
 public:
  /// Expressions are chosen among those whose AUs the names hold; a name may carry "L" or "R".
  PerformerScript(const std::vector<std::string>& au_names, double seconds, std::uint64_t seed);

  /// Sets all intensities. Times must not decrease until rewind().
  void intensities_at(double time_s, std::span<double> intensities) noexcept;
  void rewind() noexcept { first_active_ = 0; }
  /// Sorted by begin.
  const std::vector<AuPulse>& pulses() const noexcept { return pulses_; }

 private:
  std::vector<AuPulse> pulses_;
  std::size_t first_active_ = 0;  ///< every earlier pulse is over
};

}  // namespace risorius
