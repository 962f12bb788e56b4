// A take to write, by the extension of its name.
#pragma once

#include <filesystem>
#include <memory>

#include "replay/takes/take.h"

namespace risorius {

/// That a take can be written there, before any work. Throws UserError.
void check_take_output(const std::filesystem::path& path);

/// .c3d or .csv. Throws UserError.
std::unique_ptr<TakeWriter> make_take_writer(const std::filesystem::path& path, const MarkerSet& markers);

}  // namespace risorius
