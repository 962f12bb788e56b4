// Small takes and their bytes, for the tests of replay/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "replay/takes/c3d_writer.h"
#include "replay/takes/take.h"

namespace risorius::test {

inline MarkerSet sample_set(std::size_t markers, double rate_hz = 120) {
  MarkerSet set{.rate_hz = rate_hz};
  for (std::size_t i = 0; i < markers; ++i) set.names.push_back("marker " + std::to_string(i + 1));
  return set;
}

/// Positions with awkward bits that differ between all frames and markers; none is (0,0,0).
inline MarkerFrame sample_frame(std::uint64_t index, std::size_t markers, double rate_hz = 120) {
  MarkerFrame frame;
  frame.header.sequence = index;
  frame.header.capture_time_ns = capture_time_of(index, rate_hz);
  frame.count = static_cast<std::uint32_t>(markers);
  for (std::size_t i = 0; i < markers; ++i) {
    frame.state[i] = MarkerState::kMeasured;
    const auto n = static_cast<float>(i + 1), t = static_cast<float>(index);
    frame.position_mm[i] = {n * 10.1f + t / 7.0f, -n / 3.0f - t, 1e-3f * n * t + 0.7f};
  }
  return frame;
}

inline void write_c3d(const std::filesystem::path& path, std::size_t markers, std::uint64_t frames) {
  C3dWriter writer(path, sample_set(markers), "0.1.0");
  for (std::uint64_t i = 0; i < frames; ++i) writer.write(sample_frame(i, markers));
  writer.finish();
}

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_bytes(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::remove(
      path);  // a truncated file is flushed to the disk when closed, a new one is not: 20 times faster
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Where the name of a parameter stands in the bytes of a C3D file; not where it is part of a longer name.
inline std::size_t offset_of_name(const std::string& bytes, const std::string& name) {
  for (std::size_t at = bytes.find(name, 512); at != std::string::npos; at = bytes.find(name, at + 1))
    if (bytes[at - 2] == static_cast<char>(name.size())) return at;
  throw std::runtime_error("no parameter " + name);
}

/// Where the values of a parameter begin.
inline std::size_t offset_of_parameter(const std::string& bytes, const std::string& name) {
  const std::size_t dimensions_at = offset_of_name(bytes, name) + name.size() + 3;
  return dimensions_at + 1 + static_cast<unsigned char>(bytes[dimensions_at]);
}

inline void patch_word(std::string& bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<char>(value & 0xFF);
  bytes[at + 1] = static_cast<char>(value >> 8);
}

/// Makes readers overlook a parameter.
inline void hide_parameter(std::string& bytes, const std::string& name) { bytes[offset_of_name(bytes, name)] = '#'; }

inline std::vector<MarkerFrame> read_all(TakeReader& reader) {
  std::vector<MarkerFrame> frames;
  MarkerFrame frame;
  while (reader.next(frame)) frames.push_back(frame);
  return frames;
}

inline bool has_warning(const TakeReader& reader, std::string_view part) {
  for (const std::string& warning : reader.info().warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

/// The message of the UserError that `action` throws; empty if it throws none.
template <class Error, class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace risorius::test
