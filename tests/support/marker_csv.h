// Reads a wide marker CSV (frame,time_s,NAME_x,NAME_y,NAME_z,...; centimetres) for the tests and benches of repair.
#pragma once

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"

namespace risorius::test {

struct MarkerTake {
  MarkerSet set;
  std::vector<MarkerFrame> frames;
};

inline double distance_mm(Position a, Position b) {
  return std::hypot(double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z});
}

inline MarkerTake read_marker_csv(const std::filesystem::path& path, double rate_hz) {
  constexpr float kMmPerCm = 10;
  MarkerTake take;
  take.set.rate_hz = rate_hz;
  std::ifstream file(path);
  std::string line, cell;
  std::getline(file, line);
  std::istringstream header(line);
  for (int column = 0; std::getline(header, cell, ','); ++column) {
    if (column >= 2 && (column - 2) % 3 == 0) take.set.names.push_back(cell.substr(0, cell.size() - 2));
  }
  while (std::getline(file, line)) {
    MarkerFrame& frame = take.frames.emplace_back();
    frame.header.sequence = take.frames.size() - 1;
    frame.header.capture_time_ns = std::llround(static_cast<double>(take.frames.size() - 1) * 1e9 / rate_hz);
    frame.count = static_cast<std::uint32_t>(take.set.names.size());
    const char* at = line.c_str();
    const auto next = [&at] {
      at = std::strchr(at, ',') + 1;
      return std::strtof(at, nullptr);
    };
    next();
    for (std::size_t i = 0; i < frame.count; ++i) {
      const float x = next(), y = next(), z = next();
      frame.state[i] = MarkerState::kMeasured;
      frame.position_mm[i] = {kMmPerCm * x, kMmPerCm * y, kMmPerCm * z};
    }
  }
  return take;
}

}  // namespace risorius::test
