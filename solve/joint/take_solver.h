// A whole take solved at once: head poses and intensities of all frames, joined by the smoothness of their course
// (solve/README.md, eq. 4). The causal solve (solve/au_solver.h) goes first: it finds the poses about which the problem
// is linear and the weights of the markers. Then windows of frames are solved in parallel, each with its neighbours
// held (Schwarz's alternating method), until the certificate of the whole take stands. Where the neutral is free, it is
// found by turns with the intensities (take_neutral.h). The result does not depend on the number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "solve/au_solver.h"
#include "solve/joint/joint_frame.h"
#include "solve/joint/joint_window.h"

namespace risorius {

struct TakeSolverOptions {
  AuSolverOptions solve;            ///< its temporal penalty is the causal solve's only
  double smoothness = 1;            ///< [1e-6, 1e6]: of a resting AU's course, relative to the Gram matrix, at 60 Hz
  double acceleration_per_s2 = 40;  ///< (0, 1e6]: an AU whose course bends so is smoothed half as much
  double neutral_mm = 0;            ///< [0, 20]: standard deviation of the neutral, per axis; 0 keeps the rig's
  int threads = 0;                  ///< 0: as many as the machine has
};

/// Frames done, of all; called from several threads, one at a time.
using TakeSolverProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;

class TakeSolver {
 public:
  /// Throws UserError for a rig that is not valid, std::invalid_argument for options out of range.
  TakeSolver(Rig rig, const TakeSolverOptions& options);

  /// Of the take's frames in order, all of the set: one AuFrame each. Frames that the causal solve refused stay as it
  /// left them; AUs that it held are bridged in time and still called held. Throws UserError if rig and set do not fit.
  std::vector<AuFrame> solve(const MarkerSet& set, std::span<const MarkerFrame> frames,
                             const TakeSolverProgress& progress = {});

  /// The rig with the neutral of the take solved last: its own where `neutral_mm` is 0.
  const Rig& rig_of_take() const noexcept { return rig_of_take_; }

 private:
  struct Take;
  void solve_causally(const MarkerSet& set, std::span<const MarkerFrame> frames, Take& take) const;
  void find_neutral(const MarkerSet& set, std::span<const MarkerFrame> frames, Take& take) const;
  void join(Take& take) const;
  void smooth_by_course(Take& take) const;
  void certify(Take& take, const TakeSolverProgress& progress, std::uint64_t all) const;
  double sweep(Take& take, int rounds, const TakeSolverProgress& progress) const;
  void publish(Take& take) const;

  Rig rig_, rig_of_take_;
  TakeSolverOptions options_;
  Eigen::VectorXd upper_;
};

}  // namespace risorius
