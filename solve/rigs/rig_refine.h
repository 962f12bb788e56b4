// Refines a rig on takes of its actor, after Choe & Ko (2001): solve every frame with the basis at hand, update the
// basis by the intensities found (basis_update.h), and so on. A guard keeps what each AU means: where the update would
// turn an AU too far from its start, change its strength too much, move skin far from where it acted, or make it look
// more like another AU than like itself, only that part of the way is gone that respects the limits. Deterministic.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "solve/au_solver_options.h"
#include "solve/rigs/basis_update.h"
#include "solve/rigs/rig.h"
#include "solve/rigs/solved_take.h"

namespace risorius {

struct RigRefineOptions {
  int rounds = 6;                                 ///< of solve and update, 1 to 100
  BasisPrior prior;                               ///< around the start
  AuSolverOptions solve{.ridge = 5e-3, .l1 = 3};  ///< with the usual l1, shrunk intensities stretch the shapes
  double independent_s = 4;                       ///< frames closer in time than this tell partly the same, > 0
  double least_noise_mm = 0.2;                    ///< per axis: what the model leaves at best, > 0
  bool chooses_stabilisers = true;                ///< anew, where the takes show that one moves with the face
  double least_intensity = 0.25;                  ///< an AU that stays below is not in the takes, (0, 1)
  double least_moved_mm = 0.5;  ///< takes whose markers move less (90th percentile, head's motion out) say nothing, > 0
  double least_cosine = 0.6;    ///< of an AU's field to its start, (0, 1)
  double least_gain = 0.4, largest_gain = 2.5;  ///< of an AU's size to its start's
  double largest_far_share = 0.2;               ///< of an AU's energy, where its start does not reach, [0, 1)
};

/// What became of one AU.
struct AuRefinement {
  std::string au;
  double peak = 0;      ///< 98th percentile of its intensity in the takes, with the refined rig
  double active_s = 0;  ///< time above `least_intensity`
  double moved_mm = 0;  ///< the largest change of its displacement at a marker, at intensity 1
  double turned_degrees = 0;
  double gain = 1;        ///< size, refined / start
  bool informed = false;  ///< it is in the takes; others change only where neighbours in the prior do: not at all
  bool guarded = false;   ///< the guard held it back
};

struct RigRefinement {
  Rig rig;
  std::vector<AuRefinement> aus;
  double neutral_moved_mm = 0;  ///< the largest shift of a marker's neutral
  std::string neutral_moved_marker;
  double residual_before_mm = 0, residual_after_mm = 0;  ///< rms per measured marker on the takes themselves
  std::vector<std::string> stabilisers_dropped, stabilisers_added;
  std::size_t frames = 0;
  int rounds = 0;
  std::vector<std::string> warnings;
};

using RefineProgress = std::function<void(std::size_t done, std::size_t of)>;

/// Throws UserError naming the take: markers that the rig does not know, no solvable frame, a take in which no AU
/// moves; std::invalid_argument for options out of range.
RigRefinement refine_rig(const Rig& start, const std::vector<TakeFrames>& takes, const RigRefineOptions& options = {},
                         const RefineProgress& progress = {});

}  // namespace risorius
