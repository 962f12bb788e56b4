// Calibration tried where the truth is known: an actor who is not the built-in face performs a neutral and every AU
// once, with noise, occlusions and false tracks; the rig that is calibrated from those takes is compared with the
// actor's own.
#pragma once

#include <string>

namespace risorius::bench {

struct CalibrationError {
  double wrong_share = 0;  ///< of the basis energy over all AUs
  double worst_share = 0;  ///< of one AU's own energy
  std::string worst_au;
};

CalibrationError calibrate_performed_takes(double noise_mm);

}  // namespace risorius::bench
