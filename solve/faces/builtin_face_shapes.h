// The AU shapes of the built-in face: smooth fields over space, one or more per muscle. A pull moves the skin about
// the muscle's insertion towards its origin; a gather draws it to the middle of the lips (orbicularis oris); the jaw
// turns about its hinge. Weights have compact support, so that each shape is local, and the right side mirrors the
// left.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace risorius {

/// Names of the shapes, in the order of the face's AUs.
std::vector<std::string> builtin_au_names();

/// Displacement of a point of the resting built-in face by shape `index` at intensity 1. Millimetres.
Eigen::Vector3d builtin_displacement_mm(std::size_t index, const Eigen::Vector3d& point_mm);

}  // namespace risorius
