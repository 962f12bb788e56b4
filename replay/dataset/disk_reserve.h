// Room on the disk that is kept free for the end: what is needed to complete a take when everything else is full.
#pragma once

#include <cstddef>
#include <filesystem>

#include "replay/unfinished_paths.h"

namespace risorius {

class DiskReserve {
 public:
  /// Takes `bytes` of the disk with a file at `path`; none where the file system cannot promise room or is full.
  DiskReserve(std::filesystem::path path, std::size_t bytes);
  ~DiskReserve();
  DiskReserve(const DiskReserve&) = delete;
  DiskReserve& operator=(const DiskReserve&) = delete;

  /// Gives the room back: for the files that are now to be written.
  void release() noexcept;

 private:
  std::filesystem::path path_;
  UnfinishedPath unfinished_;
  bool held_ = false;
};

}  // namespace risorius
