// ICT-FaceKit's published files, for benches that have them.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "support/test_data.h"

namespace risorius::bench {

/// The folder of the OBJ files; empty where the archive is not there.
inline std::optional<std::filesystem::path> unpack_ict(const std::filesystem::path& into) {
  const std::filesystem::path archive = test::data_folder() / "ict_facekit.tar.xz";
  if (test::data_folder().empty() || !std::filesystem::exists(archive)) return {};
  const std::string command = "tar -xJf '" + archive.string() + "' -C '" + into.string() + "'";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("cannot run: " + command);
  return into / "ict_facekit";
}

}  // namespace risorius::bench
