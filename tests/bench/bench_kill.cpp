// The daemon killed with SIGKILL while it records, many times: what is lost, whether everything before it is bit-exact,
// and whether it solves again to the same bits.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/core.h>
#include <random>

#include "bench/bench_report.h"
#include "support/test_data.h"
#include "system/killed_session.h"

namespace risorius::bench {
namespace {

int run(int kills, std::uint32_t seed) {
  BenchReport report("kill");
  std::mt19937 random(seed);
  double longest_s = 0;
  std::uint64_t frames = 0, corrupted = 0, equal = 0, different = 0;
  int failed = 0;
  for (int i = 0; i < kills; ++i) {
    test::TemporaryFolder folder;
    // At any moment of a chunk's time.
    const double seconds = 0.6 + std::uniform_real_distribution<double>(0, 1.5)(random);
    const test::KilledSession killed = test::record_and_kill(folder.path(), seconds);
    if (!killed.problem.empty()) {
      ++failed;
      fmt::print("kill {}: {}\n", i + 1, killed.problem);
      continue;
    }
    fmt::print("kill {:>3} after {:.2f} s: {:.3f} s lost, {} frames kept, {} corrupted, {} equal, {} different\n",
               i + 1, seconds, killed.lost_s, killed.frames, killed.corrupted_frames, killed.solved_equal,
               killed.solved_different);
    std::fflush(stdout);
    longest_s = std::max(longest_s, killed.lost_s);
    frames += killed.frames;
    corrupted += killed.corrupted_frames;
    equal += killed.solved_equal;
    different += killed.solved_different;
  }
  report.add("kills", kills);
  report.add("files that could not be recovered", failed);
  report.add("longest loss", longest_s);
  report.add("frames kept", static_cast<double>(frames));
  report.add("corrupted earlier frames", static_cast<double>(corrupted));
  report.add("solved again: equal messages", static_cast<double>(equal));
  report.add("solved again: different messages", static_cast<double>(different));
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  CLI::App app("The daemon killed while it records, and what is left of the session.");
  int kills = 50;
  std::uint32_t seed = 1;
  app.add_option("--kills", kills, "how many")->check(CLI::Range(1, 10000))->capture_default_str();
  app.add_option("--seed", seed, "of the moments")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return risorius::bench::run(kills, seed);
}
