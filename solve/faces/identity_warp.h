// A coarse identity: the smooth and symmetric deformation that brings a generic face to what was observed of a person.
//
// The displacement of a point is a Gaussian process, as in the morphable models of Luethi, Gerig, Jung and Vetter
// (2018): each component has a prior standard deviation, points closer than a length move alike, and a point and its
// mirror image (x -> -x) move as mirror images. The warp is the process's mean given the observations; where nothing
// was observed within some lengths, it is the generic face.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace risorius {

struct IdentityPrior {
  double deviation_mm = 2;  ///< of a component of the displacement, off the mirror plane, > 0
  double length_mm = 60;    ///< > 0
};

/// `direction` . displacement(at) = shift, with this standard deviation (> 0).
struct WarpObservation {
  Eigen::Vector3d at_mm, direction;
  double shift_mm = 0, deviation_mm = 1;
};

class IdentityWarp {
 public:
  /// Stays where it is.
  IdentityWarp() = default;
  /// Takes time in the cube of the observations: 0.01 s for 200.
  IdentityWarp(const std::vector<WarpObservation>& observations, const IdentityPrior& prior);

  Eigen::Vector3d displacement_mm(const Eigen::Vector3d& p_mm) const noexcept;
  Eigen::Vector3d operator()(const Eigen::Vector3d& p_mm) const noexcept { return p_mm + displacement_mm(p_mm); }
  /// Derivative of operator(): how a small motion at p is carried over.
  Eigen::Matrix3d jacobian(const Eigen::Vector3d& p_mm) const noexcept;

 private:
  Eigen::Matrix3Xd centres_mm_;  ///< the observed places and their mirror images
  Eigen::Matrix3Xd pulls_mm_;    ///< of each centre, at the centre
  double length_mm_ = 1;
};

}  // namespace risorius
