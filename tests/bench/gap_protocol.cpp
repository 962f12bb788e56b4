#include "bench/gap_protocol.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>

namespace risorius::bench {
namespace {

constexpr double kColouredS = 0.25;
constexpr int kMostTries = 2000;

void add_noise(std::vector<MarkerFrame>& frames, double coloured_mm, double rate_hz, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  const double keep = std::exp(-1 / (kColouredS * rate_hz));
  std::vector<std::array<double, 3>> lasting(frames.front().count);
  for (auto& axes : lasting) {
    for (double& x : axes) x = coloured_mm > 0 ? coloured_mm * normal(random) : 0;
  }
  for (MarkerFrame& frame : frames) {
    for (std::size_t i = 0; i < frame.count; ++i) {
      float* const axes[3] = {&frame.position_mm[i].x, &frame.position_mm[i].y, &frame.position_mm[i].z};
      for (std::size_t k = 0; k < 3; ++k) {
        if (coloured_mm > 0) {
          lasting[i][k] = keep * lasting[i][k] + std::sqrt(1 - keep * keep) * coloured_mm * normal(random);
        }
        *axes[k] += static_cast<float>(kNoiseMm * normal(random) + lasting[i][k]);
      }
    }
  }
}

/// Whether marker i was measured in the whole stretch and one frame around it.
bool is_whole(const std::vector<MarkerFrame>& clean, std::size_t i, std::size_t begin, std::size_t end) {
  for (std::size_t f = begin - 1; f <= end; ++f) {
    if (clean[f].state[i] != MarkerState::kMeasured) return false;
  }
  return true;
}

void hide(std::vector<MarkerFrame>& frames, std::size_t i, std::size_t begin, std::size_t end) {
  for (std::size_t f = begin; f < end; ++f) {
    frames[f].state[i] = MarkerState::kMissing;
    frames[f].position_mm[i] = {};
  }
}

}  // namespace

std::vector<GapTask> gap_tasks(double rate_hz) {
  std::vector<GapTask> tasks;
  for (const std::size_t markers : {4, 12}) {
    for (const std::size_t gap : {6, 30, 60, 120}) {
      tasks.push_back({.name = fmt::format("{}x{}", gap, markers), .gap_frames = gap, .markers = markers});
    }
  }
  tasks.push_back({.name = "region",
                   .gap_frames = static_cast<std::size_t>(std::lround(0.5 * (rate_hz > 0 ? rate_hz : 60))),
                   .region_mm = 40});
  tasks.push_back({.name = "coloured 30x4", .gap_frames = 30, .markers = 4, .coloured_noise_mm = 0.2});
  return tasks;
}

std::string problem_with(const test::MarkerTake& clean, const GapTask& task) {
  const std::size_t needed = kFirstGapFrame + 2 * (task.gap_frames + 3);
  if (clean.frames.size() < needed) {
    return fmt::format("{} frames, the task needs {}", clean.frames.size(), needed);
  }
  std::size_t seen = 0;
  for (std::size_t i = 0; i < clean.set.names.size(); ++i) {
    const auto measured = std::count_if(clean.frames.begin(), clean.frames.end(), [i](const MarkerFrame& frame) {
      return frame.state[i] == MarkerState::kMeasured;
    });
    seen += 2 * static_cast<std::size_t>(measured) > clean.frames.size();
  }
  const std::size_t least = std::max<std::size_t>(6, task.markers + 3);
  return seen >= least ? "" : fmt::format("{} markers are seen half of the time, the task needs {}", seen, least);
}

std::vector<MarkerFrame> draw_gaps(const test::MarkerTake& clean, const GapTask& task, std::uint64_t draw) {
  std::mt19937_64 random(draw + 1);
  std::vector<MarkerFrame> frames = clean.frames;
  add_noise(frames, task.coloured_noise_mm, clean.set.rate_hz > 0 ? clean.set.rate_hz : 60, random);
  std::vector<std::size_t> markers(frames.front().count);
  for (std::size_t i = 0; i < markers.size(); ++i) markers[i] = i;
  std::shuffle(markers.begin(), markers.end(), random);
  const std::size_t half = (frames.size() - kFirstGapFrame) / 2;
  const auto draw_begin = [&](std::size_t part) {
    return kFirstGapFrame + part * half + random() % (half - task.gap_frames - 1);
  };
  if (task.region_mm > 0) {
    for (std::size_t part = 0; part < 2; ++part) {
      const std::size_t begin = draw_begin(part), centre = markers[part];
      for (const std::size_t i : markers) {
        const bool near = test::distance_mm(clean.frames[begin].position_mm[i],
                                            clean.frames[begin].position_mm[centre]) <= task.region_mm;
        if (near && is_whole(clean.frames, i, begin, begin + task.gap_frames)) {
          hide(frames, i, begin, begin + task.gap_frames);
        }
      }
    }
    return frames;
  }
  std::size_t cut = 0;
  for (std::size_t k = 0; cut < task.markers && k < markers.size(); ++k) {
    std::size_t parts = 0;
    for (std::size_t part = 0; part < 2; ++part) {
      for (int attempt = 0; attempt < kMostTries; ++attempt) {
        const std::size_t begin = draw_begin(part);
        if (!is_whole(clean.frames, markers[k], begin, begin + task.gap_frames)) continue;
        hide(frames, markers[k], begin, begin + task.gap_frames);
        ++parts;
        break;
      }
    }
    cut += parts > 0;
  }
  return frames;
}

}  // namespace risorius::bench
