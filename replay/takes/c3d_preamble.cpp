#include "replay/takes/c3d_preamble.h"

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "replay/takes/c3d_numbers.h"

namespace risorius {
namespace {

constexpr std::uint8_t kParameterBlock = 2;
constexpr std::uint64_t kMaxWord = 65535;
constexpr std::size_t kMaxRows = 255;  // a dimension is one byte

/// Builds the records of a parameter section. Record: name length, group id, name, offset to the next record, body.
class ParameterSection {
 public:
  void begin_group(std::string_view name) {
    ++group_id_;
    append_record(name, static_cast<std::int8_t>(-group_id_), "");
  }
  void add_integers(std::string_view name, std::initializer_list<std::uint64_t> values) {
    std::string data;
    for (const std::uint64_t value : values) append_c3d_word(data, static_cast<std::uint16_t>(value));
    add(name, 2, values.size() == 1 ? std::string() : std::string(1, static_cast<char>(values.size())), data);
  }
  void add_float(std::string_view name, float value) {
    std::string data;
    append_c3d_float(data, value);
    add(name, 4, "", data);
  }
  void add_text(std::string_view name, std::string_view text) {
    add(name, -1, std::string(1, static_cast<char>(text.size())), text);
  }
  /// One row per text, as wide as the longest; NAME2 goes on after 255 rows.
  void add_texts(const std::string& name, const std::vector<std::string>& texts) {
    std::size_t width = 1;
    for (const std::string& text : texts) width = std::max(width, text.size());
    for (std::size_t first = 0, part = 1; first < texts.size(); first += kMaxRows, ++part) {
      const std::size_t rows = std::min(kMaxRows, texts.size() - first);
      std::string data;
      for (std::size_t row = 0; row < rows; ++row) {
        data += texts[first + row];
        data.append(width - texts[first + row].size(), ' ');
      }
      add(part == 1 ? name : name + std::to_string(part), -1, {static_cast<char>(width), static_cast<char>(rows)},
          data);
    }
  }
  const std::string& records() const noexcept { return records_; }

 private:
  void add(std::string_view name, int type, const std::string& dimensions, std::string_view data) {
    std::string body{static_cast<char>(type), static_cast<char>(dimensions.size())};
    body += dimensions;
    body += data;
    append_record(name, group_id_, body);
  }
  void append_record(std::string_view name, std::int8_t id, std::string_view body) {
    constexpr std::size_t kOffsetBytes = 2, kDescriptionLengthBytes = 1;
    records_ += static_cast<char>(name.size());
    records_ += static_cast<char>(id);
    records_ += name;
    append_c3d_word(records_, static_cast<std::uint16_t>(kOffsetBytes + body.size() + kDescriptionLengthBytes));
    records_ += body;
    records_ += '\0';  // no description
  }

  std::string records_;
  std::int8_t group_id_ = 0;
};

void add_point_group(ParameterSection& section, const MarkerSet& markers, std::uint64_t frame_count,
                     std::uint64_t data_block) {
  section.begin_group("POINT");
  section.add_integers("USED", {markers.names.size()});
  section.add_float("SCALE", -1.0f);
  section.add_float("RATE", static_cast<float>(markers.rate_hz));
  section.add_integers("DATA_START", {data_block});
  section.add_integers("FRAMES", {std::min(frame_count, kMaxWord)});
  section.add_float("LONG_FRAMES", static_cast<float>(frame_count));
  section.add_text("UNITS", "mm");
  section.add_text("X_SCREEN", "+X");
  section.add_text("Y_SCREEN", "+Y");
  section.add_texts("LABELS", markers.names);
  section.add_texts("DESCRIPTIONS", std::vector<std::string>(markers.names.size(), " "));
}

std::string parameter_records(const MarkerSet& markers, const std::string& software_version, std::uint64_t frame_count,
                              std::uint64_t data_block) {
  ParameterSection section;
  add_point_group(section, markers, frame_count, data_block);
  // Many readers take these two for granted.
  section.begin_group("ANALOG");
  section.add_integers("USED", {0});
  section.add_float("GEN_SCALE", 1.0f);
  section.add_float("RATE", 0.0f);
  section.begin_group("FORCE_PLATFORM");
  section.add_integers("USED", {0});
  section.begin_group("TRIAL");
  section.add_integers("ACTUAL_START_FIELD", {1, 0});
  section.add_integers("ACTUAL_END_FIELD", {frame_count & kMaxWord, frame_count >> 16});
  section.begin_group("MANUFACTURER");
  section.add_text("COMPANY", "Risorius");
  section.add_text("SOFTWARE", "Risorius");
  section.add_text("VERSION_LABEL", software_version);
  return section.records();
}

std::string header_block(const MarkerSet& markers, std::uint64_t frame_count, std::uint64_t data_block) {
  std::string block{static_cast<char>(kParameterBlock), '\x50'};                        // word 1
  append_c3d_word(block, static_cast<std::uint16_t>(markers.names.size()));             // 2: points
  append_c3d_word(block, 0);                                                            // 3: analog values per frame
  append_c3d_word(block, 1);                                                            // 4: first frame
  append_c3d_word(block, static_cast<std::uint16_t>(std::min(frame_count, kMaxWord)));  // 5: last frame
  append_c3d_word(block, 0);                                                            // 6: longest interpolated gap
  append_c3d_float(block, -1.0f);                                  // 7-8: scale, negative = float points
  append_c3d_word(block, static_cast<std::uint16_t>(data_block));  // 9
  append_c3d_word(block, 0);                                       // 10: analog values per channel
  append_c3d_float(block, static_cast<float>(markers.rate_hz));    // 11-12
  block.resize(kC3dBlockBytes, '\0');
  return block;
}

}  // namespace

void append_c3d_word(std::string& bytes, std::uint16_t value) {
  bytes += static_cast<char>(value & 0xFF);
  bytes += static_cast<char>(value >> 8);
}

void append_c3d_float(std::string& bytes, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  append_c3d_word(bytes, static_cast<std::uint16_t>(bits & 0xFFFF));
  append_c3d_word(bytes, static_cast<std::uint16_t>(bits >> 16));
}

std::string encode_c3d_preamble(const MarkerSet& markers, const std::string& software_version,
                                std::uint64_t frame_count) {
  // Section header (reserved, key, number of blocks, processor), records, and two zero bytes that end them.
  constexpr std::size_t kSectionHeaderBytes = 4, kEndBytes = 2;
  const std::size_t records_bytes = parameter_records(markers, software_version, frame_count, 0).size();
  const std::size_t blocks = (kSectionHeaderBytes + records_bytes + kEndBytes + kC3dBlockBytes - 1) / kC3dBlockBytes;
  const std::uint64_t data_block = kParameterBlock + blocks;
  std::string preamble = header_block(markers, frame_count, data_block);
  preamble += {'\x01', '\x50', static_cast<char>(blocks), static_cast<char>(C3dProcessor::kIntel)};
  preamble += parameter_records(markers, software_version, frame_count, data_block);
  preamble.resize((data_block - 1) * kC3dBlockBytes, '\0');
  return preamble;
}

}  // namespace risorius
