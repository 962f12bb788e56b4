// risorius rom --connect: the poses of a range of motion asked for one after the other while a daemon runs, each
// checked as soon as the face is back at rest, and asked for again where it was not seen.
#pragma once

#include <string>
#include <vector>

#include "replay/commands/curve_arguments.h"
#include "solve/rigs/pose_check.h"

namespace CLI {
class App;
}

namespace risorius {

struct RomLiveArguments {
  std::string endpoint;  ///< the daemon's publish address; empty: not live
  std::string stream;
  std::vector<std::string> only;  ///< poses, such as AU12; empty: all of the stream's AUs
  double seconds = 20;            ///< for each pose; without a frame for so long, the daemon is called silent
  int tries = 2;
  double least_peak = 0.4;
  std::string output;  ///< CSV
  CurveArguments curve;

  void add_to(CLI::App& command);
};

/// Ends with the last pose or an interrupt. The CSV holds every pose that was answered, also when it ends with a
/// UserError.
void prompt_live(const RomLiveArguments& arguments);

void print_pose_head();
void print_pose(const PoseCheck& pose);

}  // namespace risorius
