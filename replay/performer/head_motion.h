// How the head wanders: six coordinates of coloured motion (amplitude falling with frequency from 0.05 to 2.5 Hz), a
// few millimetres and degrees about a seated place. A function of time alone.
#pragma once

#include <array>
#include <cstdint>

#include "capture/frames.h"

namespace risorius {

class HeadMotion {
 public:
  /// `strength` 0 (still) to 3; 1 stays within 8 mm and 5 degrees per coordinate.
  HeadMotion(double strength, std::uint64_t seed);

  Pose at(double time_s) const noexcept;

 private:
  static constexpr std::size_t kWaves = 6;
  struct Wave {
    double amplitude = 0, radians_per_s = 0, phase = 0;
  };
  std::array<std::array<Wave, kWaves>, 6> waves_{};  ///< x, y, z in mm; pitch, yaw, roll in radians
};

}  // namespace risorius
