// Positions as the frames hold them (float) and as the arithmetic wants them (double).
#pragma once

#include <Eigen/Core>

#include "capture/frames.h"

namespace risorius {

inline Eigen::Vector3d to_vector(Position p) noexcept { return {p.x, p.y, p.z}; }
inline Position to_position(const Eigen::Vector3d& v) noexcept {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace risorius
