// What must not stay behind when a signal ends a program: files under their .partial names, folders without content.
// AtomicFile and TakeDataset enter their paths here; a program that wants them removed on Ctrl-C says so once.
#pragma once

#include <filesystem>

namespace risorius {

/// Enters a path for its lifetime. Beyond a few hundred at once, or of more than 4095 bytes, a path is not entered: it
/// would stay behind, no more.
class UnfinishedPath {
 public:
  explicit UnfinishedPath(const std::filesystem::path& path) noexcept;
  ~UnfinishedPath();
  UnfinishedPath(const UnfinishedPath&) = delete;
  UnfinishedPath& operator=(const UnfinishedPath&) = delete;

 private:
  int slot_ = -1;
};

/// SIGINT, SIGTERM and SIGHUP first remove the entered files, then the entered folders as far as they are empty, and
/// then end the program as they always do. For the main of a program without clean-up of its own.
void remove_unfinished_paths_on_signals() noexcept;

}  // namespace risorius
