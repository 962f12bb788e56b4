// Inputs as files, for readers that want a path.
#pragma once

#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <unistd.h>

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

/// A file in memory where the system has such a place, for readers that want a path. One of each name, written anew for
/// each input.
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
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  const std::filesystem::path& write(std::span<const std::byte> bytes) {
    std::FILE* file = std::fopen(path_.c_str(), "wb");
    require(file != nullptr, "the file is made");
    const bool written = bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    require(written, "the file is written");
    std::fclose(file);
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
};

}  // namespace risorius::fuzz
