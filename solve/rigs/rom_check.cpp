#include "solve/rigs/rom_check.h"

#include "capture/errors.h"

namespace risorius {

std::vector<PoseCheck> check_range_of_motion(const Rig& rig, const TakeFrames& take, double least_peak,
                                             const AuSolverOptions& options) {
  std::vector<PoseFrame> frames;
  explain_take(rig, take, options, [&](const ExplainedFrame& frame) {
    const std::int64_t time_ns =
        difference_ns(take.frames[frame.index].header.capture_time_ns, take.frames.front().header.capture_time_ns);
    frames.push_back({static_cast<double>(time_ns) * 1e-9, frame.x});
  });
  if (frames.empty()) {
    throw UserError(take.place, "not one frame could be solved with this rig",
                    "is it a take of this actor; are unit and axes right?");
  }
  std::vector<PoseCheck> poses;
  const std::vector<std::string> names = rig.au_names();
  for (std::size_t i = 0; i < names.size(); ++i) poses.push_back(check_pose(names, frames, i, least_peak));
  return poses;
}

}  // namespace risorius
