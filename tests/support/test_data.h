// Where the tests find recordings, and where they may write.
#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <string>

namespace risorius::test {

/// RISORIUS_DATA, or ../shared/data beside the checkout; empty if neither is there.
std::filesystem::path data_folder();

/// A fresh empty folder for this test, below the system's temporary folder; removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace risorius::test

// A macro, because GTEST_SKIP must return from the test itself.
#define RISORIUS_NEEDS_DATA(variable, relative)                                      \
  const std::filesystem::path variable = risorius::test::data_folder() / (relative); \
  if (risorius::test::data_folder().empty() || !std::filesystem::exists(variable))   \
  GTEST_SKIP() << "no " << (relative) << ": set RISORIUS_DATA to the data folder"
