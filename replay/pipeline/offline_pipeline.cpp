#include "replay/pipeline/offline_pipeline.h"

#include <cmath>
#include <fmt/format.h>

#include "capture/check.h"
#include "capture/errors.h"
#include "solve/rigs/rig_motion.h"

namespace risorius {
namespace {

constexpr std::uint64_t kProgressStride = 64;

void refuse_unfit_rig(const TakeReader& take, const FramePipeline& pipeline) {
  if (!pipeline.rig_problem().empty()) throw UserError(take.info().path.string() + ": " + pipeline.rig_problem());
}

template <class Act>
void name_take_in_error(const TakeReader& take, Act&& act) {
  try {
    act();
  } catch (const UserError& error) {
    throw UserError(take.info().path.string() + ": " + error.what());
  }
}

/// The rig of the take, whose source says how far its neutral is from the given one.
Rig with_shift_told(const Rig& given, Rig of_take) {
  const Eigen::VectorXd shift_mm = (of_take.neutral_mm - given.neutral_mm).colwise().norm();
  Eigen::Index most = 0;
  const double most_mm = shift_mm.maxCoeff(&most);
  of_take.source +=
      fmt::format("; neutral found with the take's AUs, markers moved by {:.2f} mm rms, most {} by {:.2f} mm",
                  std::sqrt(shift_mm.squaredNorm() / static_cast<double>(shift_mm.size())),
                  of_take.marker_names[static_cast<std::size_t>(most)], most_mm);
  return of_take;
}

}  // namespace

std::vector<MarkerFrame> read_despiked(TakeReader& take, const DespikerOptions& options) {
  Despiker despiker(options);
  despiker.use_marker_set(take.info().markers);
  std::vector<MarkerFrame> frames;
  MarkerFrame frame, cleaned;
  while (take.next(frame)) {
    RISORIUS_CHECK(despiker.push(frame));
    while (despiker.pop(cleaned)) frames.push_back(cleaned);
  }
  despiker.flush();
  while (despiker.pop(cleaned)) frames.push_back(cleaned);
  return frames;
}

void solve_causally(TakeReader& take, FramePipeline& pipeline, const SolvedFrameSink& sink,
                    const FrameProgress& progress) {
  pipeline.use_marker_set(take.info().markers);
  refuse_unfit_rig(take, pipeline);
  const std::uint64_t all = take.info().frame_count.value_or(0);
  MarkerFrame frame;
  SolvedFrame solved;
  for (std::uint64_t done = 0; take.next(frame);) {
    RISORIUS_CHECK(pipeline.push(frame));
    while (pipeline.pop(solved)) sink(solved);
    if (++done % kProgressStride == 0) progress(done, all);
  }
  pipeline.flush();
  while (pipeline.pop(solved)) sink(solved);
}

void solve_both_directions(TakeReader& take, const PipelineOptions& options, const Rig& rig,
                           const SolvedFrameSink& sink, const FrameProgress& progress) {
  AuSolver solver(rig, options.solve);
  name_take_in_error(take, [&] { solver.use_marker_set(take.info().markers); });
  std::vector<MarkerFrame> frames = read_despiked(take, options.despike);
  fill_offline(frames, take.info().markers, {.known_motion = motion_of(rig)});
  SolvedFrame solved;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    solved.markers = frames[i];
    RISORIUS_CHECK(solver.push(solved.markers) && solver.pop(solved.aus));
    sink(solved);
    if (i % kProgressStride == 0) progress(i, frames.size());
  }
}

void solve_jointly(TakeReader& take, const PipelineOptions& options, const Rig& rig, const JointSolve& joint,
                   const std::function<void(const Rig&)>& begin, const SolvedFrameSink& sink,
                   const FrameProgress& progress) {
  std::vector<MarkerFrame> frames = read_despiked(take, options.despike);
  fill_offline(frames, take.info().markers, {.known_motion = motion_of(rig)});
  TakeSolver solver(rig, {.solve = options.solve, .neutral_mm = joint.neutral_mm, .threads = joint.threads});
  std::vector<AuFrame> solved;
  name_take_in_error(take, [&] { solved = solver.solve(take.info().markers, frames, progress); });
  begin(joint.neutral_mm > 0 ? with_shift_told(rig, solver.rig_of_take()) : rig);
  for (std::size_t i = 0; i < frames.size(); ++i) sink({frames[i], solved[i]});
}

}  // namespace risorius
