// The face that the performer really has, which need not be the rig that a solver is given: another person (identity),
// muscles of another strength and direction (basis), markers glued a little elsewhere (placement), and skin that slides
// on bent paths and does not come back exactly (slide). Otherwise a solver would be tested on its own model.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "replay/performer/random.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// All 0: the rig itself. `like_people()` is what --perturb means.
struct PerturbOptions {
  double identity_mm = 0;   ///< root mean square of a smooth change of the neutral, 0 to 20
  double basis_share = 0;   ///< of each AU's displacement: strength, direction and shape, 0 to 0.5
  double placement_mm = 0;  ///< standard deviation per axis of the markers' places on the face, 0 to 10
  double slide_share = 0;   ///< of an AU's displacement: how far its path bends half way, 0 to 0.5
  double creep_mm = 0;      ///< standard deviation of a slow wandering of each marker (20 s), 0 to 5

  static PerturbOptions like_people() { return {4, 0.15, 2, 0.08, 0.2}; }
};

class TruthModel {
 public:
  /// Throws std::invalid_argument for options out of range.
  TruthModel(const Rig& rig, const PerturbOptions& options, double rate_hz, std::uint64_t seed);

  /// Markers of the next frame in the head's frame (3 x M) at these intensities. Allocates nothing.
  void pose_next(std::span<const double> intensities, Eigen::Matrix3Xd& head_mm) noexcept;
  void rewind() noexcept;

  /// The true face as a rig: its neutral and its displacements at intensity 1 (slide bends only the way there).
  const Rig& rig() const noexcept { return rig_; }

 private:
  void change_identity(const PerturbOptions& options, Random& random);
  void place_markers(const PerturbOptions& options, Random& random);
  void change_basis(const PerturbOptions& options, Random& random);

  Rig rig_;
  double slide_share_, creep_mm_, creep_keep_;
  std::uint64_t seed_;
  Random creep_random_;
  std::vector<Eigen::Matrix3Xd> bend_mm_;  ///< per AU; empty without slide
  Eigen::Matrix3Xd creep_mm_now_;
};

}  // namespace risorius
