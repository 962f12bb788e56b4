// Who the built-in face is: a few shape parameters, and the smooth warp of space that they make of the average head.
// Mesh, AU fields and landmarks go through the same warp, so they stay together.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

namespace risorius {

/// All zero: the average head. Each within the range of kIdentityParameters.
struct FaceIdentity {
  double face_width = 0;   ///< share of the average's, added
  double face_height = 0;  ///< share
  double jaw_width = 0;    ///< share, below the mouth
  double nose_length_mm = 0;
  double nose_width = 0;     ///< share
  double brow_depth_mm = 0;  ///< forward
  double lip_fullness_mm = 0;
  double eye_spacing_mm = 0;  ///< pupil to pupil
  double chin_forward_mm = 0;
};

struct IdentityParameter {
  std::string_view name;
  double FaceIdentity::*value;
  double least, greatest;
};

// Ranges: about two standard deviations of adults (Farkas 1994: bizygomatic 137 +- 5 mm, nasion-menton 121 +- 7,
// bigonial 106 +- 7, nose 53 +- 4 long and 35 +- 3 wide, interpupillary 63 +- 4).
inline constexpr std::array kIdentityParameters = std::to_array<IdentityParameter>({
    {"face_width", &FaceIdentity::face_width, -0.07, 0.07},
    {"face_height", &FaceIdentity::face_height, -0.07, 0.07},
    {"jaw_width", &FaceIdentity::jaw_width, -0.10, 0.12},
    {"nose_length_mm", &FaceIdentity::nose_length_mm, -3.5, 3.5},
    {"nose_width", &FaceIdentity::nose_width, -0.15, 0.20},
    {"brow_depth_mm", &FaceIdentity::brow_depth_mm, -2.5, 3},
    {"lip_fullness_mm", &FaceIdentity::lip_fullness_mm, -1.2, 2},
    {"eye_spacing_mm", &FaceIdentity::eye_spacing_mm, -4, 4},
    {"chin_forward_mm", &FaceIdentity::chin_forward_mm, -5, 4},
});

/// Drawn evenly from the ranges; the same seed gives the same identity on every machine. Seed 0: the average.
FaceIdentity face_identity_of_seed(std::uint64_t seed);

/// Where a point of the average head (mm) lies in this one. Symmetric in x, smooth, never folds.
Eigen::Vector3d warped_mm(const FaceIdentity& identity, const Eigen::Vector3d& p_mm) noexcept;

}  // namespace risorius
