// Inputs as files, for readers that want a path.
#pragma once

#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <unistd.h>

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

/// A file in memory where the system has such a place, for readers that want a path. One of each name, overwritten
/// with each input.
class InputFile {
 public:
  explicit InputFile(const std::string& name) {
    const std::filesystem::path memory = "/dev/shm";
    const auto parent = std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
    folder_ = parent / fmt::format("risorius-fuzz-{}-{}", ::getpid(), name);
    std::filesystem::create_directories(folder_);
    path_ = folder_ / name;
  }
  ~InputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  const std::filesystem::path& write(std::span<const std::byte> bytes) {
    // Opened once: opening and making it anew for each input cost readers of small files up to a tenth.
    if (descriptor_ < 0) descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    require(descriptor_ >= 0, "the file is made");
    const bool written = ::pwrite(descriptor_, bytes.data(), bytes.size(), 0) == static_cast<::ssize_t>(bytes.size());
    require(written && ::ftruncate(descriptor_, static_cast<::off_t>(bytes.size())) == 0, "the file is written");
    return path_;
  }
  Bytes read() const {
    std::ifstream file(path_, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    return bytes_of(text);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path folder_, path_;
  int descriptor_ = -1;  ///< of writing; before the first there is no file, which some makers of seeds insist on
};

}  // namespace risorius::fuzz
