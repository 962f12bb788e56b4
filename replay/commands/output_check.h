// Before anything is written: no output may be an input, or another output, whatever way its path is written; and
// finished datasets stay as they are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace risorius {

/// Empty paths are ignored; "builtin" is no file. Throws UserError naming the path.
void check_outputs(const std::vector<std::filesystem::path>& inputs, const std::vector<std::filesystem::path>& outputs);

/// Before the work whose result goes there: a file of this name can be made. `endings`: of which it must have one, such
/// as ".c3d". `what`: such as "a take". Throws UserError.
void check_output_name(const std::filesystem::path& path, const std::string& what,
                       const std::vector<std::string>& endings);

/// A folder that is to be written into: neither it nor one that it lies in is a finished dataset, whose manifest
/// another file would belie. Throws UserError naming the dataset.
void check_not_sealed(const std::filesystem::path& folder);

}  // namespace risorius
