// What can be judged on real takes, where no truth is known: AUs that must be absent, markers left out.
#pragma once

#include <filesystem>
#include <string>

#include "bench/bench_report.h"
#include "solve/faces/face_model.h"

namespace risorius::bench {

/// The takes of the committed list that are there, with rigs fitted from the face and not refined.
void measure_real_takes(const std::string& face_name, const FaceModel& face, BenchReport& report);

/// A take and a rig of the user's own: printed. Throws UserError.
void look_at_take(const std::filesystem::path& take, const std::filesystem::path& rig);

}  // namespace risorius::bench
