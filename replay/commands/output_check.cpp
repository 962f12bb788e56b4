#include "replay/commands/output_check.h"

#include "capture/errors.h"

namespace risorius {
namespace {

bool are_one_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;  // of files that are not there yet, only the names can be compared
  if (std::filesystem::equivalent(a, b, error)) return true;
  const auto whole_a = std::filesystem::weakly_canonical(std::filesystem::absolute(a), error);
  const auto whole_b = std::filesystem::weakly_canonical(std::filesystem::absolute(b), error);
  return whole_a == whole_b;
}

}  // namespace

void check_outputs(const std::vector<std::filesystem::path>& inputs,
                   const std::vector<std::filesystem::path>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (outputs[i].empty()) continue;
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

}  // namespace risorius
