// Before anything is written: no output may be an input, or another output, whatever way its path is written.
#pragma once

#include <filesystem>
#include <vector>

namespace risorius {

/// Empty paths are ignored; "builtin" is no file. Throws UserError naming the path.
void check_outputs(const std::vector<std::filesystem::path>& inputs, const std::vector<std::filesystem::path>& outputs);

}  // namespace risorius
