#include <algorithm>
#include <cstring>

#include "capture/check.h"
#include "capture/wire/natnet_codec.h"

namespace risorius {
namespace {

// Appends to a datagram; its header is completed at the end. Sections of 4.1 get their size when they are closed.
class Writer {
 public:
  Writer(NatnetMessage message, NatnetDatagram& out) : out_(out) {
    out_.clear();
    write(static_cast<std::uint16_t>(message));
    write(std::uint16_t{0});
  }
  template <class T>
  void write(T value) {
    append(&value, sizeof value);
  }
  void write_string(std::string_view text) {
    append(text.data(), text.size());
    write(std::byte{0});
  }
  /// `text` and zeros, `size` bytes in all.
  void write_padded(std::string_view text, std::size_t size) {
    const std::size_t end = out_.size() + size;
    write_string(text.substr(0, size - 1));
    out_.resize(end);
  }
  void write_count(std::size_t count) { write(static_cast<std::int32_t>(count)); }
  /// Where the size of a section stands that begins here.
  std::size_t begin_size(NatnetVersion version) {
    if (version.sized()) write(std::int32_t{0});
    return out_.size();
  }
  void end_size(NatnetVersion version, std::size_t begin) {
    if (version.sized()) put(begin - 4, static_cast<std::int32_t>(out_.size() - begin));
  }
  void empty_section(NatnetVersion version) {
    write_count(0);
    if (version.sized()) write_count(0);
  }
  void finish() {
    RISORIUS_CHECK(out_.size() - 4 <= 0xFFFF);
    put(2, static_cast<std::uint16_t>(out_.size() - 4));
  }

 private:
  void append(const void* bytes, std::size_t size) {
    const std::size_t at = out_.size();
    out_.resize(at + size);
    if (size > 0) std::memcpy(out_.data() + at, bytes, size);
  }
  template <class T>
  void put(std::size_t at, T value) {
    std::memcpy(out_.data() + at, &value, sizeof value);
  }
  NatnetDatagram& out_;
};

void write_position(Writer& writer, const NatnetLabelledMarker& marker) {
  writer.write(marker.x);
  writer.write(marker.y);
  writer.write(marker.z);
}

void write_version(Writer& writer, NatnetVersion version) {
  for (const std::uint8_t part : {version.major, version.minor, version.build, version.revision}) writer.write(part);
}

}  // namespace

void encode_connect(NatnetConnectForm form, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kConnect, out);
  if (form == NatnetConnectForm::kPing) writer.write_string("Ping");
  if (form == NatnetConnectForm::kSender) {
    writer.write_padded("risorius", 256);
    write_version(writer, {});
    write_version(writer, {4, 1});
  }
  writer.finish();
}

void encode_masked_model_request(NatnetDatagram& out) {
  Writer writer(NatnetMessage::kRequestModelDef, out);
  writer.write(std::uint32_t{3});
  writer.finish();
}

void encode_bare(NatnetMessage message, NatnetDatagram& out) { Writer(message, out).finish(); }

void encode_text(NatnetMessage message, std::string_view text, NatnetDatagram& out) {
  Writer writer(message, out);
  writer.write_string(text);
  writer.finish();
}

void encode_response(float value, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kResponse, out);
  writer.write(value);
  writer.finish();
}

void encode_response(std::int32_t value, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kResponse, out);
  writer.write(value);
  writer.finish();
}

void encode_server_info(const NatnetServerInfo& info, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kServerInfo, out);
  writer.write_padded(info.name, 256);
  for (const std::uint8_t part : info.application_version) writer.write(part);
  write_version(writer, info.version);
  writer.write(info.clock_frequency);
  writer.write(info.data_port);
  writer.write(static_cast<std::uint8_t>(info.multicast));
  for (const std::uint8_t part : info.group) writer.write(part);
  writer.finish();
}

void encode_echo_request(std::uint64_t client_ticks, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kEchoRequest, out);
  writer.write(client_ticks);
  writer.finish();
}

void encode_echo_response(const NatnetEcho& echo, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kEchoResponse, out);
  writer.write(echo.client_ticks);
  writer.write(echo.host_ticks);
  writer.finish();
}

void encode_model(std::span<const NatnetAsset> marker_sets, NatnetVersion version, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kModelDef, out);
  writer.write_count(marker_sets.size());
  for (const NatnetAsset& set : marker_sets) {
    writer.write_count(0);  // the type: a marker set
    const std::size_t begin = writer.begin_size(version);
    writer.write_string(set.name);
    writer.write_count(set.marker_names.size());
    for (const std::string& name : set.marker_names) writer.write_string(name);
    writer.end_size(version, begin);
  }
  writer.finish();
}

void encode_frame(const NatnetFrameToSend& frame, NatnetVersion version, NatnetDatagram& out) {
  Writer writer(NatnetMessage::kFrameOfData, out);
  writer.write(frame.frame_number);
  writer.write_count(1);
  const std::size_t sets = writer.begin_size(version);
  writer.write_string(frame.marker_set);
  writer.write_count(frame.markers.size());
  for (const auto& marker : frame.markers) write_position(writer, marker);
  writer.end_size(version, sets);
  writer.empty_section(version);                       // unlabelled
  writer.empty_section(version);                       // rigid bodies
  writer.empty_section(version);                       // skeletons
  if (version.sized()) writer.empty_section(version);  // assets
  writer.write_count(frame.markers.size());
  const std::size_t labelled = writer.begin_size(version);
  for (const auto& marker : frame.markers) {
    writer.write(marker.id);
    write_position(writer, marker);
    writer.write(marker.size);
    writer.write(marker.params);
    writer.write(marker.residual);
  }
  writer.end_size(version, labelled);
  writer.empty_section(version);  // force plates
  writer.empty_section(version);  // devices
  const NatnetSuffix& suffix = frame.suffix;
  writer.write(suffix.timecode);
  writer.write(suffix.timecode_sub);
  writer.write(suffix.timestamp_s);
  writer.write(suffix.mid_exposure_ticks);
  writer.write(suffix.data_received_ticks);
  writer.write(suffix.transmit_ticks);
  if (version.sized()) {
    writer.write(std::uint32_t{0});  // precision time: not used
    writer.write(std::uint32_t{0});
  }
  writer.write(suffix.params);
  writer.write(std::int32_t{0});
  writer.finish();
}

}  // namespace risorius
