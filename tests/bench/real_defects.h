// What repair makes of recordings whose defects are real: nobody knows the truth, so what is counted is what was found
// and filled, and how far markers leap from frame to frame on a head held still, before and after.
#pragma once

#include <filesystem>

#include "bench/bench_report.h"

namespace risorius::bench {

/// Prints a table, adds rows, and draws each take's most repaired markers into build/bench/repair_NAME.png. Takes that
/// are not in the folder are an error.
void bench_real_defects(const std::filesystem::path& data_folder, BenchReport& report);

}  // namespace risorius::bench
