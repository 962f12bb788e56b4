// A seeded face for the tests of solve/: markers on half an ellipsoid, AUs as smooth bumps of displacement, and marker
// frames made from known intensities and a known pose.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/rigid_alignment.h"
#include "solve/rigs/rig.h"

namespace risorius::test {

/// Markers M0, M1, ...; the first 6 are stabilisers at the forehead that no AU moves. AUs AU1L, AU1R, AU2L, ...
Rig synthetic_rig(int marker_count, int au_count, unsigned seed = 1);

/// The rig's markers as a set, in the rig's order, id 7.
MarkerSet marker_set_of(const Rig& rig);

/// Every marker measured where the rig puts it, at 60 frames/s.
MarkerFrame marker_frame(const Rig& rig, const Eigen::VectorXd& x, const RigidTransform& world_from_head = {},
                         std::uint64_t sequence = 0);

/// Adds normal noise per axis to the measured markers.
void add_noise(MarkerFrame& frame, double standard_deviation_mm, unsigned seed);

/// Smooth in time, between 0 and 1, about half of them 0 at any time.
Eigen::VectorXd smooth_intensities(int au_count, double time_s, unsigned seed = 1);

}  // namespace risorius::test
