#include "replay/takes/c3d_layout.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <unordered_set>

#include "capture/errors.h"
#include "capture/utf8.h"

namespace risorius {
namespace {

using Warnings = std::vector<std::string>;

/// The parameters are the authority and the header is their copy: it serves where they say nothing.
std::uint64_t agreed_count(const C3dSource& source, std::string_view name, std::uint64_t in_header,
                           Warnings& warnings) {
  const auto in_parameters = source.parameters.count("POINT", name);
  if (!in_parameters) return in_header;
  if (*in_parameters != in_header)
    warnings.push_back(fmt::format("POINT:{} is {} and the header says {}", name, *in_parameters, in_header));
  return *in_parameters;
}

float agreed_scale(const C3dSource& source, Warnings& warnings) {
  const float in_header = source.header.scale;
  const float scale = source.parameters.number("POINT", "SCALE").value_or(in_header);
  // Among float files the value has no use for positions, only its sign; writers leave it different.
  if (std::signbit(scale) != std::signbit(in_header))
    warnings.push_back(fmt::format("POINT:SCALE is {} and the header says {}", scale, in_header));
  if (!std::isfinite(scale) || scale == 0)
    throw UserError(source.place, fmt::format("POINT:SCALE is {}", scale),
                    "it must be finite and not 0; export the take again as float C3D");
  return scale;
}

double agreed_rate_hz(const C3dSource& source, Warnings& warnings) {
  if (source.options.rate_hz) return *source.options.rate_hz;
  const auto is_rate = [](float rate) { return std::isfinite(rate) && rate > 0; };
  const float in_header = source.header.rate_hz;
  const float rate = source.parameters.number("POINT", "RATE").value_or(in_header);
  if (is_rate(rate)) return rate;
  if (!is_rate(in_header))
    throw UserError(source.place, fmt::format("POINT:RATE is {} Hz", rate), "give the rate of the take");
  warnings.push_back(fmt::format("POINT:RATE is {} Hz: the header's {} Hz is used", rate, in_header));
  return in_header;
}

double agreed_unit_mm(const C3dSource& source, Warnings& warnings) {
  if (source.options.mm_per_unit) return *source.options.mm_per_unit;
  const auto units = source.parameters.texts("POINT", "UNITS");
  std::string unit = units.empty() ? "" : units[0];
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (unit.empty()) {
    warnings.push_back("POINT:UNITS is empty: mm assumed");
    return 1;
  }
  const auto mm_per_unit = parse_unit(unit);
  if (!mm_per_unit)
    throw UserError(source.place, "POINT:UNITS is '" + units[0] + "'", "mm, cm and m are known; give the unit");
  return *mm_per_unit;
}

void cut_to_capacity(std::string& name) {
  const auto continues_a_character = [&](std::size_t at) {
    return (static_cast<unsigned char>(name[at]) & 0xC0) == 0x80;
  };
  std::size_t bytes = kMaxNameBytes;
  while (bytes > 0 && continues_a_character(bytes)) --bytes;
  name.resize(bytes);
}

/// LABELS, LABELS2, LABELS3 ... each hold at most 255 rows.
std::vector<std::string> all_labels(const C3dSource& source) {
  std::vector<std::string> labels = source.parameters.texts("POINT", "LABELS");
  for (int part = 2; source.parameters.has("POINT", fmt::format("LABELS{}", part)); ++part)
    for (std::string& label : source.parameters.texts("POINT", fmt::format("LABELS{}", part)))
      labels.push_back(std::move(label));
  return labels;
}

std::vector<std::string> unique_names(const C3dSource& source, std::size_t points, Warnings& warnings) {
  std::vector<std::string> names = all_labels(source);
  const auto is_named = [](const std::string& name) { return !name.empty(); };
  const auto surplus = names.size() <= points
                           ? 0
                           : std::count_if(names.begin() + static_cast<std::ptrdiff_t>(points), names.end(), is_named);
  if (surplus > 0)
    warnings.push_back(
        fmt::format("{} labels for {} points: {} of the rest name nothing", names.size(), points, surplus));
  names.resize(points);
  const auto unnamed = static_cast<std::size_t>(std::count(names.begin(), names.end(), ""));
  if (unnamed > 0)
    warnings.push_back(fmt::format("{} of {} points have no label: named point_N after their number", unnamed, points));

  std::unordered_set<std::string> taken;
  for (std::size_t i = 0; i < points; ++i) {
    std::string& name = names[i];
    if (!is_clean_utf8(name)) {
      warnings.push_back(
          fmt::format("label of point {} is not UTF-8: read as Latin-1, '{}'", i + 1, shown(utf8_of(name))));
      name = utf8_of(name);
    }
    const std::string original = name.empty() ? fmt::format("point_{}", i + 1) : name;
    name = original;
    if (name.size() > kMaxNameBytes) cut_to_capacity(name);
    for (int copy = 2; !taken.insert(name).second; ++copy) {
      const std::string suffix = fmt::format("_{}", copy);
      name = original.substr(0, kMaxNameBytes - suffix.size()) + suffix;
    }
    if (name != original)
      warnings.push_back(fmt::format("label '{}' of point {} is read as '{}'", original, i + 1, name));
  }
  return names;
}

/// How many frames the file claims to have, from the most to the least able to say so.
std::vector<std::uint64_t> claimed_frame_counts(const C3dSource& source) {
  constexpr std::uint64_t kSaturated = 65535;  // as much as 16 bits can say: "this many or more"
  std::vector<std::uint64_t> claims;
  const auto first = source.parameters.count("TRIAL", "ACTUAL_START_FIELD");
  const auto last = source.parameters.count("TRIAL", "ACTUAL_END_FIELD");
  if (first && last && *first >= 1 && *last >= *first) claims.push_back(*last - *first + 1);
  if (const auto frames = source.parameters.count("POINT", "LONG_FRAMES")) claims.push_back(*frames);
  const auto frames = source.parameters.count("POINT", "FRAMES");
  if (frames && *frames != kSaturated) claims.push_back(*frames);
  const C3dHeader& header = source.header;
  if (header.last_frame >= header.first_frame && header.first_frame >= 1 && header.last_frame != kSaturated)
    claims.push_back(std::uint64_t{header.last_frame} - header.first_frame + 1);
  std::erase(claims, 0u);
  return claims;
}

std::uint64_t agreed_frame_count(const C3dSource& source, std::uint64_t whole_frames, Warnings& warnings) {
  const auto claims = claimed_frame_counts(source);
  if (claims.empty()) {
    warnings.push_back(fmt::format("the number of frames is not stated: {} fit into the file's length", whole_frames));
    return whole_frames;
  }
  const auto fitting = std::find_if(claims.begin(), claims.end(), [&](std::uint64_t n) { return n <= whole_frames; });
  if (fitting == claims.end()) {
    warnings.push_back(
        fmt::format("the file is truncated: {} frames declared, {} whole ones found", claims[0], whole_frames));
    return whole_frames;
  }
  if (std::any_of(claims.begin(), claims.end(), [&](std::uint64_t n) { return n != *fitting; }))
    warnings.push_back(fmt::format("the file's statements of its number of frames differ: {} taken of {}", *fitting,
                                   fmt::join(claims, ", ")));
  return *fitting;
}

void note_vertical_axis(const C3dSource& source, Warnings& warnings) {
  const auto vertical = source.parameters.texts("POINT", "Y_SCREEN");
  if (source.options.axes || vertical.empty() || vertical[0].empty() || vertical[0] == "+Y" || vertical[0] == "Y")
    return;
  warnings.push_back("POINT:Y_SCREEN is '" + vertical[0] + "', so y is probably not up in this file: give its axes");
}

std::uint64_t agreed_data_offset(const C3dSource& source, Warnings& warnings) {
  std::uint64_t block = agreed_count(source, "DATA_START", source.header.data_block, warnings);
  const auto is_inside = [&](std::uint64_t b) { return b >= 2 && (b - 1) * kC3dBlockBytes < source.file_bytes; };
  if (!is_inside(block)) block = source.header.data_block;
  if (!is_inside(block))
    throw UserError(source.place,
                    fmt::format("POINT:DATA_START is block {} of a file of {} bytes", block, source.file_bytes),
                    "the file is truncated before its first frame, or damaged; export the take again");
  return (block - 1) * kC3dBlockBytes;
}

std::size_t agreed_point_count(const C3dSource& source, Warnings& warnings) {
  const std::uint64_t points = agreed_count(source, "USED", source.header.points, warnings);
  if (points == 0)
    throw UserError(source.place, "POINT:USED is 0: the file holds no points, only analog channels or nothing",
                    "export the take with its 3D points");
  if (points > kMaxMarkers)
    throw UserError(source.place,
                    fmt::format("POINT:USED is {}; a frame holds at most {} markers", points, kMaxMarkers),
                    "export the face's markers only");
  return static_cast<std::size_t>(points);
}

}  // namespace

C3dLayout resolve_c3d_layout(const C3dSource& source, Warnings& warnings) {
  constexpr std::size_t kWordsPerPoint = 4;
  C3dLayout layout{.processor = source.processor};
  const std::size_t points = agreed_point_count(source, warnings);
  const float scale = agreed_scale(source, warnings);
  layout.float_points = std::signbit(scale);
  layout.scale = layout.float_points ? 1 : scale;
  layout.markers.rate_hz = agreed_rate_hz(source, warnings);
  layout.markers.mm_per_unit = agreed_unit_mm(source, warnings);
  layout.markers.axes = source.options.axes.value_or(Axes());
  layout.markers.names = unique_names(source, points, warnings);
  note_vertical_axis(source, warnings);

  layout.data_offset = agreed_data_offset(source, warnings);
  layout.frame_bytes = (kWordsPerPoint * points + source.header.analog_per_frame) *
                       (layout.float_points ? sizeof(float) : sizeof(std::int16_t));
  const std::uint64_t whole_frames = (source.file_bytes - layout.data_offset) / layout.frame_bytes;
  if (whole_frames == 0)
    throw UserError(source.place,
                    fmt::format("no whole frame: {} bytes after offset {}, a frame has {}",
                                source.file_bytes - layout.data_offset, layout.data_offset, layout.frame_bytes),
                    "the file is truncated; export the take again");
  layout.frame_count = agreed_frame_count(source, whole_frames, warnings);
  return layout;
}

}  // namespace risorius
