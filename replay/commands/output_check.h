// Before anything is written: no output may be an input, or another output, whatever way its path is written; and
// finished datasets stay as they are.
#pragma once

#include <filesystem>
#include <vector>

namespace risorius {

/// Empty paths are ignored; "builtin" is no file. Throws UserError naming the path.
void check_outputs(const std::vector<std::filesystem::path>& inputs, const std::vector<std::filesystem::path>& outputs);

/// A folder that is to be written into: neither it nor one that it lies in is a finished dataset, whose manifest
/// another file would belie. Throws UserError naming the dataset.
void check_not_sealed(const std::filesystem::path& folder);

}  // namespace risorius
