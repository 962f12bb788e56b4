// The manifest of a dataset folder: the SHA-256 of every file in it, in the format that `sha256sum -c` checks.
#pragma once

#include <filesystem>
#include <string>

namespace risorius {

inline constexpr const char* kManifestName = "manifest-sha256.txt";

/// Lower-case hexadecimal SHA-256 (FIPS 180-4) of a file's bytes. Throws UserError if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

/// Writes FOLDER/manifest-sha256.txt over all other regular files below FOLDER, sorted by their relative path.
/// Call it last: that it is there means that the folder is complete. Atomic. Throws UserError.
void write_manifest(const std::filesystem::path& folder);

}  // namespace risorius
