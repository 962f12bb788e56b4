// Blocks of steps of different implementations of one network, in turn, so that a noisy machine is noisy for all.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "capture/monotonic_clock.h"

namespace risorius::bench {

/// Median over blocks of the time per step in us, by name. Every block of one is followed by a block of each other.
inline std::map<std::string, double> step_times_us(
    const std::vector<std::pair<std::string, std::function<void()>>>& steps) {
  constexpr int kBlocks = 60, kSteps = 25, kWarmUp = 3;
  std::map<std::string, std::vector<double>> blocks;
  for (int block = 0; block < kBlocks + kWarmUp; ++block) {
    for (const auto& [name, step] : steps) {
      const std::int64_t begin_ns = monotonic_now_ns();
      for (int i = 0; i < kSteps; ++i) step();
      const double us = static_cast<double>(monotonic_now_ns() - begin_ns) * 1e-3 / kSteps;
      if (block >= kWarmUp) blocks[name].push_back(us);
    }
  }
  std::map<std::string, double> medians;
  for (auto& [name, times] : blocks) {
    std::nth_element(times.begin(), times.begin() + kBlocks / 2, times.end());
    medians[name] = times[kBlocks / 2];
  }
  return medians;
}

}  // namespace risorius::bench
