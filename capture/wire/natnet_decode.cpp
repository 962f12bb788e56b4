// Frames and the small messages; model definitions are in natnet_decode_model.cpp.
#include <algorithm>
#include <cmath>

#include "capture/wire/natnet_codec.h"
#include "capture/wire/natnet_reader.h"

namespace risorius {
namespace {

constexpr std::size_t kRigidBodyBytes = 38;  // id, position, quaternion, mean error, params: 3.0 on
constexpr std::size_t kSuffixBytes = 46, kPrecisionTimeBytes = 8;

NatnetSuffix read_suffix(NatnetReader& reader, bool sized, bool& plausible) noexcept {
  NatnetSuffix suffix;
  suffix.timecode = reader.read<std::uint32_t>();
  suffix.timecode_sub = reader.read<std::uint32_t>();
  suffix.timestamp_s = reader.read<double>();
  suffix.mid_exposure_ticks = reader.read<std::uint64_t>();
  suffix.data_received_ticks = reader.read<std::uint64_t>();
  suffix.transmit_ticks = reader.read<std::uint64_t>();
  if (sized) reader.take(kPrecisionTimeBytes);
  suffix.params = reader.read<std::int16_t>();
  const auto end = reader.read<std::int32_t>();
  const auto in_order = [](std::uint64_t first, std::uint64_t then) { return then == 0 || first <= then; };
  const bool has_time = suffix.timestamp_s > 0 || suffix.mid_exposure_ticks > 0;
  plausible = reader.ok() && end == 0 && has_time && std::isfinite(suffix.timestamp_s) && suffix.timestamp_s >= 0 &&
              in_order(suffix.mid_exposure_ticks, suffix.data_received_ticks) &&
              in_order(suffix.data_received_ticks, suffix.transmit_ticks);
  return suffix;
}

// What lies between the last section that we know and the suffix in a newer version is sections too. They are passed
// over for as long as what stands there cannot be a suffix.
NatnetSuffix find_suffix(NatnetReader& reader, bool sized) noexcept {
  NatnetReader ahead = reader;
  while (sized && ahead.ok() && ahead.remaining() >= kSuffixBytes + kPrecisionTimeBytes) {
    bool plausible = false;
    NatnetReader here(ahead.rest_bytes());
    const NatnetSuffix suffix = read_suffix(here, sized, plausible);
    if (plausible || here.remaining() == 0) {
      reader.take(reader.remaining() - here.remaining());
      return suffix;
    }
    ahead.read<std::int32_t>();
    ahead.take(ahead.count(1), 1);
  }
  bool ignored = false;
  return read_suffix(reader, sized, ignored);
}

void skip_marker_sets(NatnetReader& reader, std::uint32_t count) noexcept {
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    reader.string();
    reader.take(reader.count(12), 12);
  }
}

// Force plates and devices.
void skip_channels(NatnetReader& reader, std::uint32_t count) noexcept {
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    reader.read<std::int32_t>();
    const std::uint32_t channels = reader.count(4);
    for (std::uint32_t c = 0; c < channels && reader.ok(); ++c) reader.take(reader.count(4), 4);
  }
}

void read_unsized(NatnetReader& reader, NatnetFrame& frame) noexcept {
  frame.marker_set_count = reader.count(5);
  const auto sets = reader.rest_bytes();
  skip_marker_sets(reader, frame.marker_set_count);
  frame.marker_sets = sets.first(sets.size() - reader.remaining());
  reader.take(reader.count(12), 12);  // unlabelled
  reader.take(reader.count(kRigidBodyBytes), kRigidBodyBytes);
  const std::uint32_t skeletons = reader.count(8);
  for (std::uint32_t i = 0; i < skeletons && reader.ok(); ++i) {
    reader.read<std::int32_t>();
    reader.take(reader.count(kRigidBodyBytes), kRigidBodyBytes);
  }
  const std::uint32_t labelled = reader.count(NatnetLabelledMarker::kBytes);
  frame.labelled_count = labelled;
  frame.labelled = reader.take(labelled, NatnetLabelledMarker::kBytes);
  skip_channels(reader, reader.count(8));  // force plates
  skip_channels(reader, reader.count(8));  // devices
}

struct Section {
  std::uint32_t count = 0;
  std::span<const std::byte> bytes;
};

Section take_section(NatnetReader& reader) noexcept {
  Section section;
  section.count = reader.count(0);
  section.bytes = reader.take(reader.count(1), 1);
  if (!reader.ok()) section = {};
  return section;
}

void read_sized(NatnetReader& reader, NatnetFrame& frame) noexcept {
  const Section sets = take_section(reader);
  for (int i = 0; i < 4; ++i) take_section(reader);  // unlabelled, rigid bodies, skeletons, assets
  const Section labelled = take_section(reader);
  for (int i = 0; i < 2; ++i) take_section(reader);  // force plates, devices
  if (!reader.ok()) return;
  NatnetReader inside(sets.bytes);
  skip_marker_sets(inside, sets.count);
  if (!inside.ok()) return reader.fail();
  frame.marker_set_count = sets.count;
  frame.marker_sets = sets.bytes.first(inside.position());
  if (labelled.count == 0) return;
  // A later version may make the records longer.
  if (labelled.bytes.size() % labelled.count == 0)
    frame.labelled_stride = std::max(labelled.bytes.size() / labelled.count, NatnetLabelledMarker::kBytes);
  if (labelled.count * frame.labelled_stride > labelled.bytes.size()) return reader.fail();
  frame.labelled_count = labelled.count;
  frame.labelled = labelled.bytes.first(labelled.count * frame.labelled_stride);
}

// `exact`: nothing was left over.
NatnetError decode_in_layout(std::span<const std::byte> payload, bool sized, NatnetFrame& frame, bool& exact) noexcept {
  frame = {};
  NatnetReader reader(payload);
  frame.frame_number = reader.read<std::int32_t>();
  if (sized) {
    read_sized(reader, frame);
  } else {
    read_unsized(reader, frame);
  }
  if (reader.ok()) frame.suffix = find_suffix(reader, sized);
  exact = reader.ok() && reader.remaining() == 0;
  return reader.error();
}

std::string_view until_nul(std::span<const std::byte> bytes) noexcept {
  const auto nul = std::find(bytes.begin(), bytes.end(), std::byte{0});
  return {reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(nul - bytes.begin())};
}

}  // namespace

std::span<const std::string_view> natnet_error_names() noexcept {
  static constexpr std::array<std::string_view, kNatnetErrorCount> kNames{
      "none",           "too_short",   "bad_length",       "unknown_message", "truncated",
      "bad_count",      "old_version", "unknown_sender",   "not_connected",   "unknown_model",
      "model_changing", "no_markers",  "too_many_markers", "too_many_sets",   "bad_time"};
  return kNames;
}

NatnetError decode_natnet(std::span<const std::byte> datagram, NatnetPacket& packet) noexcept {
  ByteReader reader(datagram);
  const auto id = reader.read<std::uint16_t>();
  const auto size = reader.read<std::uint16_t>();
  if (!reader.ok()) return NatnetError::kTooShort;
  if (size > reader.remaining()) return NatnetError::kBadLength;
  packet = {.id = id, .payload = reader.take(size)};
  return NatnetError::kNone;
}

NatnetError decode_server_info(std::span<const std::byte> payload, NatnetServerInfo& info) {
  ByteReader reader(payload);
  const auto name = reader.take(256);
  NatnetServerInfo read;
  for (auto& part : read.application_version) part = reader.read<std::uint8_t>();
  read.version.major = reader.read<std::uint8_t>();
  read.version.minor = reader.read<std::uint8_t>();
  read.version.build = reader.read<std::uint8_t>();
  read.version.revision = reader.read<std::uint8_t>();
  if (!reader.ok()) return NatnetError::kTruncated;
  if (read.version < NatnetVersion{3}) return NatnetError::kOldVersion;
  read.name = until_nul(name.first(255));
  // Older servers end here; what comes is all there or not there.
  if (reader.remaining() >= 15) {
    read.clock_frequency = reader.read<std::uint64_t>();
    read.data_port = reader.read<std::uint16_t>();
    read.multicast = reader.read<std::uint8_t>() != 0;
    for (auto& part : read.group) part = reader.read<std::uint8_t>();
  }
  info = std::move(read);
  return NatnetError::kNone;
}

NatnetError decode_frame(std::span<const std::byte> payload, NatnetVersion version, NatnetFrame& frame) noexcept {
  if (version < NatnetVersion{3}) return NatnetError::kOldVersion;
  bool exact = false, other_exact = false;
  const NatnetError error = decode_in_layout(payload, version.sized(), frame, exact);
  if (exact) return error;
  NatnetFrame other;
  if (decode_in_layout(payload, !version.sized(), other, other_exact) == NatnetError::kNone && other_exact) {
    frame = other;
    frame.other_layout = true;
    return NatnetError::kNone;
  }
  return error;
}

std::array<float, 3> NatnetMarkerSetView::position(std::size_t i) const noexcept {
  ByteReader reader(positions.subspan(12 * i, 12));
  const float x = reader.read<float>(), y = reader.read<float>(), z = reader.read<float>();
  return {x, y, z};
}

NatnetMarkerSetView take_marker_set(std::span<const std::byte>& marker_sets) noexcept {
  NatnetReader reader(marker_sets);
  NatnetMarkerSetView view;
  view.name = reader.string();
  view.positions = reader.take(reader.count(12), 12);
  marker_sets = reader.rest_bytes();
  return view;
}

NatnetLabelledMarker labelled_marker(const NatnetFrame& frame, std::size_t i) noexcept {
  ByteReader reader(frame.labelled.subspan(i * frame.labelled_stride, NatnetLabelledMarker::kBytes));
  NatnetLabelledMarker marker;
  marker.id = reader.read<std::int32_t>();
  marker.x = reader.read<float>();
  marker.y = reader.read<float>();
  marker.z = reader.read<float>();
  marker.size = reader.read<float>();
  marker.params = reader.read<std::int16_t>();
  marker.residual = reader.read<float>();
  return marker;
}

NatnetError decode_echo_request(std::span<const std::byte> payload, NatnetEcho& echo) noexcept {
  ByteReader reader(payload);
  echo = {.client_ticks = reader.read<std::uint64_t>()};
  return reader.ok() ? NatnetError::kNone : NatnetError::kTruncated;
}

NatnetError decode_echo_response(std::span<const std::byte> payload, NatnetEcho& echo) noexcept {
  ByteReader reader(payload);
  echo.client_ticks = reader.read<std::uint64_t>();
  echo.host_ticks = reader.read<std::uint64_t>();
  return reader.ok() ? NatnetError::kNone : NatnetError::kTruncated;
}

std::string_view decode_text(std::span<const std::byte> payload) noexcept { return until_nul(payload); }

}  // namespace risorius
