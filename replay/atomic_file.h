// A file that appears under its name only when it is complete: bytes go to PATH.partial beside it, commit() makes
// them durable and renames. Destroyed without commit, it leaves nothing behind. Disk errors are UserErrors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "replay/unfinished_paths.h"

namespace risorius {

class AtomicFile {
 public:
  /// Throws UserError if PATH.partial cannot be created.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends. Buffered; throws UserError when the disk refuses.
  void write(std::string_view bytes);
  /// Replaces bytes already written, from `offset` on.
  void overwrite(std::uint64_t offset, std::string_view bytes);
  /// Hands what is buffered to the system, so that only a failing disk can lose it.
  void flush();
  std::uint64_t flushed_bytes() const noexcept { return flushed_bytes_; }
  /// Forgets all after the first `bytes`, which were flushed, and what is buffered. Throws UserError.
  void cut_to(std::uint64_t bytes);
  /// Flush, fsync, rename. Nothing may be written afterwards.
  void commit();

  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  void write_at(std::uint64_t offset, std::string_view bytes);
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_, partial_path_;
  UnfinishedPath unfinished_;
  int descriptor_ = -1;
  bool is_committed_ = false;
  std::uint64_t flushed_bytes_ = 0;
  std::string buffer_;
};

}  // namespace risorius
