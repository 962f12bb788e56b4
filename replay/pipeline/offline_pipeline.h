// A whole take through the stages, frame by frame in causal mode (the same object as the daemon's, so the same bits),
// with the gaps filled from both sides, or, beyond that, with all frames solved at once.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "capture/repair/offline_repair.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/takes/take.h"
#include "solve/joint/take_solver.h"

namespace risorius {

using SolvedFrameSink = std::function<void(const SolvedFrame&)>;
/// Called now and then with the number of frames done, and of all (0 if not known).
using FrameProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;

/// The whole take after despiking, gaps left missing.
std::vector<MarkerFrame> read_despiked(TakeReader& take, const DespikerOptions& options);

/// Streams the take through `pipeline`; memory does not grow with the take. Throws UserError if the rig does not fit.
void solve_causally(TakeReader& take, FramePipeline& pipeline, const SolvedFrameSink& sink,
                    const FrameProgress& progress);

/// Despikes causally, fills each gap from its past, its future and the rig, then solves in order. Holds the take in
/// memory.
void solve_both_directions(TakeReader& take, const PipelineOptions& options, const Rig& rig,
                           const SolvedFrameSink& sink, const FrameProgress& progress);

struct JointSolve {
  int threads = 0;        ///< 0: as many as the machine has
  double neutral_mm = 0;  ///< deviation of a free neutral, per axis; 0 keeps the rig's
};

/// The same, but all frames are solved at once, their courses joined (solve/joint/take_solver.h). `begin` is called
/// once, before the first frame, with the rig of the take: the neutral may be another than the given rig's.
void solve_jointly(TakeReader& take, const PipelineOptions& options, const Rig& rig, const JointSolve& joint,
                   const std::function<void(const Rig&)>& begin, const SolvedFrameSink& sink,
                   const FrameProgress& progress);

}  // namespace risorius
