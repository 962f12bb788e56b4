// libFuzzer's side: `fuzz` with RISORIUS_FUZZ_TARGET=NAME in the environment. `fuzz --list` names the targets,
// `fuzz --seeds FOLDER` writes the seeds of each to FOLDER/NAME.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "fuzz/fuzz_target.h"

namespace {

using risorius::fuzz::Target;

const Target* chosen = nullptr;

void write_seeds(const std::filesystem::path& folder) {
  for (const Target& target : risorius::fuzz::targets()) {
    std::filesystem::create_directories(folder / target.name);
    int number = 0;
    for (const auto& seed : target.seeds()) {
      std::ofstream file(folder / target.name / ("seed-" + std::to_string(number++)), std::ios::binary);
      file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const std::string option = *argc > 1 ? (*argv)[1] : "";
  if (option == "--list") {
    for (const Target& target : risorius::fuzz::targets()) std::printf("%s\n", std::string(target.name).c_str());
    std::exit(0);
  }
  if (option == "--seeds" && *argc > 2) {
    write_seeds((*argv)[2]);
    std::exit(0);
  }
  const char* name = std::getenv("RISORIUS_FUZZ_TARGET");
  chosen = name == nullptr ? nullptr : risorius::fuzz::find_target(name);
  if (chosen != nullptr) return 0;
  std::fprintf(stderr, "fuzz: set RISORIUS_FUZZ_TARGET to one of those that --list names\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen->run({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
