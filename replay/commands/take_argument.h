// A take as users name it: a path, a stretch of it, or "builtin" for the synthetic performer.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "replay/takes/take.h"

namespace risorius {

/// What `name` can be, for --help.
inline constexpr const char* kTakeNames =
    "TAKE or TAKE:FROM-TO (.c3d, .csv, .trc, .txt of IEMOCAP or of a Kinect (UCI), .bnd or a folder of them; frames "
    "from 0), or \"builtin\" "
    "or \"builtin:SECONDS\"";

/// A file, a stretch of it ("PATH:FROM-TO"), or the built-in performer for "builtin" or "builtin:SECONDS".
std::unique_ptr<TakeReader> open_take_or_builtin(const std::string& name, const TakeOptions& options);

/// Without the range; "builtin" for the performer.
std::filesystem::path path_of_take(const std::string& name);

}  // namespace risorius
