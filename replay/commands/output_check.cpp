#include "replay/commands/output_check.h"

#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>
#include <unistd.h>

#include "capture/errors.h"
#include "replay/dataset/manifest.h"

namespace risorius {
namespace {

bool are_one_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;  // of files that are not there yet, only the names can be compared
  if (std::filesystem::equivalent(a, b, error)) return true;
  const auto whole_a = std::filesystem::weakly_canonical(std::filesystem::absolute(a), error);
  const auto whole_b = std::filesystem::weakly_canonical(std::filesystem::absolute(b), error);
  return whole_a == whole_b;
}

/// Before the work, not after it.
void check_can_be_written(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw UserError(path.string(), "is a folder", "give the name of a file");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error))
    throw UserError(path.string(), "cannot be written: there is no folder " + folder.string(),
                    "make it, or choose another");
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw UserError(path.string(), "cannot be written: " + std::generic_category().message(errno),
                    "choose a folder that you may write into");
}

}  // namespace

void check_outputs(const std::vector<std::filesystem::path>& inputs,
                   const std::vector<std::filesystem::path>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
    check_can_be_written(outputs[i]);
    for (const auto& input : inputs) {
      if (input.empty() || !are_one_file(input, outputs[i])) continue;
      throw UserError(outputs[i].string(), "is to be read and to be written", "give the output another name");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (outputs[j].empty() || !are_one_file(outputs[j], outputs[i])) continue;
      throw UserError(outputs[i].string(), "is to be written twice", "give each output a name of its own");
    }
  }
}

void check_output_name(const std::filesystem::path& path, const std::string& what,
                       const std::vector<std::string>& endings) {
  const std::string remedy = fmt::format("give a name that ends with {}", fmt::join(endings, " or "));
  if (path.empty()) throw UserError("--output", "is empty", remedy);
  if (std::ranges::find(endings, path.extension().string()) == endings.end())
    throw UserError(path.string(), what + " cannot be written in this form", remedy);
  check_can_be_written(path);
}

void check_not_sealed(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::path at = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), error);
  for (; !at.empty(); at = at.parent_path()) {
    if (std::filesystem::exists(at / kManifestName, error))
      throw UserError(folder.string(),
                      "would be written into a finished dataset (" + (at / kManifestName).string() + " seals it)",
                      "choose another folder with -o");
    if (at == at.parent_path()) break;
  }
}

}  // namespace risorius
