#include "support/test_data.h"

#include <cstdlib>
#include <stdexcept>

namespace risorius::test {

std::filesystem::path data_folder() {
  if (const char* folder = std::getenv("RISORIUS_DATA"); folder != nullptr && *folder != '\0') return folder;
  const std::filesystem::path beside = std::filesystem::path(RISORIUS_SOURCE_DIR).parent_path() / "shared" / "data";
  return std::filesystem::exists(beside) ? beside : std::filesystem::path();
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "risorius-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a folder like " + pattern);
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace risorius::test
