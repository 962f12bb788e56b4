#include "replay/takes/c3d_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::size_t kStreamBufferBytes = 64 * 1024;

struct Preamble {
  C3dProcessor processor = C3dProcessor::kIntel;
  C3dHeader header;
  C3dParameters parameters;
};

void read_at(std::ifstream& file, std::uint64_t offset, void* bytes, std::size_t count, const std::string& place) {
  file.clear();
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(static_cast<char*>(bytes), static_cast<std::streamsize>(count));
  if (!file)
    throw UserError(place, "cannot read " + std::to_string(count) + " bytes at offset " + std::to_string(offset),
                    "the file is truncated or was changed while it was read");
}

C3dProcessor processor_of(std::uint8_t code, std::vector<std::string>& warnings) {
  if (code >= 84 && code <= 86) return static_cast<C3dProcessor>(code);
  warnings.push_back("processor type " + std::to_string(code) + " is unknown (84 to 86 are): Intel assumed");
  return C3dProcessor::kIntel;
}

Preamble read_preamble(std::ifstream& file, std::uint64_t file_bytes, const std::string& place,
                       std::vector<std::string>& warnings) {
  std::array<std::uint8_t, kC3dBlockBytes> block{};
  if (file_bytes < block.size())
    throw UserError(place, "the file has " + std::to_string(file_bytes) + " bytes; the header alone has 512",
                    "it is empty or truncated; export the take again");
  read_at(file, 0, block.data(), block.size(), place);
  const std::uint8_t parameter_block = c3d_parameter_block(block, place);
  const std::uint64_t begin = (parameter_block - 1u) * kC3dBlockBytes;
  std::array<std::uint8_t, 4> section_header{};
  if (begin + section_header.size() > file_bytes)
    throw UserError(place,
                    "byte 1 puts the parameter section into block " + std::to_string(parameter_block) +
                        ", after the end of the file",
                    "the file is truncated; export the take again");
  read_at(file, begin, section_header.data(), section_header.size(), place);

  Preamble preamble{.processor = processor_of(section_header[3], warnings)};
  preamble.header = decode_c3d_header(block, preamble.processor);
  // The section's own block count is one byte and often wrong (0, or reaching into the data): its records end it, at
  // the latest where the data begins.
  std::uint64_t end = begin + section_header[2] * kC3dBlockBytes;
  if (preamble.header.data_block > parameter_block) end = (preamble.header.data_block - 1u) * kC3dBlockBytes;
  std::vector<std::uint8_t> section(std::max(std::min(end, file_bytes), begin) - begin);
  read_at(file, begin, section.data(), section.size(), place);
  preamble.parameters = C3dParameters(section, preamble.processor, warnings);
  return preamble;
}

bool marks_missing(const C3dLayout& layout, const std::uint8_t* fourth_word) noexcept {
  if (!layout.float_points) return c3d_integer(fourth_word, layout.processor) < 0;
  // A float file stores the VALUE of the integer word (camera mask, residual) as a float.
  const float value = c3d_float(fourth_word, layout.processor);
  if (!(value > -32769.0f && value < 65536.0f)) return true;
  return static_cast<std::int16_t>(static_cast<std::int32_t>(value)) < 0;
}

}  // namespace

C3dReader::C3dReader(const std::filesystem::path& path, const TakeOptions& options)
    : stream_buffer_(kStreamBufferBytes) {
  info_.path = path;
  const std::string place = path.string();
  file_.rdbuf()->pubsetbuf(stream_buffer_.data(), static_cast<std::streamsize>(stream_buffer_.size()));
  std::error_code error;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  if (!error) file_.open(path, std::ios::binary);
  if (error || !file_) throw UserError(place, "cannot be opened", "check the path and its permissions");

  const Preamble preamble = read_preamble(file_, file_bytes, place, info_.warnings);
  layout_ = resolve_c3d_layout({.place = place,
                                .file_bytes = file_bytes,
                                .processor = preamble.processor,
                                .header = preamble.header,
                                .parameters = preamble.parameters,
                                .options = options},
                               info_.warnings);
  info_.markers = layout_.markers;
  info_.frame_count = layout_.frame_count;
  const auto problems = problems_of(info_.markers);
  if (!problems.empty()) throw UserError(place, problems.front(), "correct the take's options");
  if (!(info_.markers.rate_hz > 0)) throw UserError(place, "the rate given is 0", "give a rate above 0 Hz");
  frame_bytes_.resize(layout_.frame_bytes);
  rewind();
}

bool C3dReader::next(MarkerFrame& frame) {
  if (next_index_ == layout_.frame_count) return false;
  file_.read(reinterpret_cast<char*>(frame_bytes_.data()), static_cast<std::streamsize>(frame_bytes_.size()));
  if (!file_)
    throw UserError(info_.path.string(), "frame " + std::to_string(next_index_) + " cannot be read",
                    "the file was changed while it was read");
  frame = MarkerFrame();
  frame.header.sequence = next_index_;
  frame.header.capture_time_ns = capture_time_of(next_index_, info_.markers.rate_hz);
  frame.count = static_cast<std::uint32_t>(info_.markers.names.size());
  const std::size_t point_bytes = layout_.float_points ? 16 : 8;
  for (std::size_t i = 0; i < frame.count; ++i) decode_point(frame_bytes_.data() + i * point_bytes, i, frame);
  ++next_index_;
  return true;
}

void C3dReader::rewind() {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(layout_.data_offset));
  next_index_ = 0;
}

void C3dReader::decode_point(const std::uint8_t* bytes, std::size_t index, MarkerFrame& frame) const noexcept {
  const std::size_t word_bytes = layout_.float_points ? 4 : 2;
  std::array<float, 3> position_mm{};
  bool all_zero = true, all_finite = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint8_t* word = bytes + axis * word_bytes;
    const double stored = layout_.float_points ? static_cast<double>(c3d_float(word, layout_.processor))
                                               : layout_.scale * c3d_integer(word, layout_.processor);
    position_mm[axis] = static_cast<float>(stored * info_.markers.mm_per_unit);
    all_zero = all_zero && stored == 0;
    all_finite = all_finite && std::isfinite(position_mm[axis]);
  }
  // Exporters disagree on how to say "missing": residual -1 by the format, (0,0,0) or NaN in the wild.
  if (all_zero || !all_finite || marks_missing(layout_, bytes + 3 * word_bytes)) return;
  frame.state[index] = MarkerState::kMeasured;
  frame.position_mm[index] = info_.markers.axes.to_world(position_mm[0], position_mm[1], position_mm[2]);
}

}  // namespace risorius
