#include "fuzz/stream_targets.h"

#include <cstring>
#include <fmt/format.h>

#include "capture/wire/crc32c.h"
#include "capture/wire/live_link_codec.h"
#include "capture/wire/live_link_session.h"
#include "capture/wire/marker_stream_decoder.h"
#include "capture/wire/natnet_session.h"
#include "capture/wire/qtm_session.h"
#include "capture/wire/reorder_window.h"
#include "capture/wire/vicon_packet_writer.h"
#include "capture/wire/vicon_session.h"

namespace risorius::fuzz {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kBeginNs = 1'000'000'000'000;

/// Time between two records: the upper half of the control byte, doubled with each; up to half a minute.
std::int64_t pause_ns(unsigned control) { return (control >> 4) == 0 ? 0 : kMs << (control >> 4); }

template <class Session>
void require_balance(const Session& session) {
  require(session.counters().datagrams.balanced(), "the ledger of datagrams balances");
  require(session.counters().frames.balanced(), "the ledger of frames balances");
}

void require_frame(const SourceEvent& event, const MarkerSet*& set) {
  if (event.kind == SourceEventKind::kMarkerSet) set = event.set;
  if (event.kind != SourceEventKind::kFrame) return;
  require(set != nullptr, "a set comes before its frames");
  require(event.frame.count <= kMaxMarkers, "a frame has no more markers than there can be");
}

}  // namespace

void run_native(std::span<const std::byte> input) {
  MarkerStreamDecoder decoder({.event_capacity = 3});  // small rings: an input should cost little to begin
  ReorderWindow window;
  SourceEvent event;
  MarkerFrame frame;
  const MarkerSet* set = nullptr;
  std::int64_t now_ns = kBeginNs;
  for (Record record; take_record(input, record);) {
    now_ns += pause_ns(record.control);
    // Without a right checksum nothing gets beyond it: most records are given one.
    if (auto& bytes = record.bytes; (record.control & 1) == 0 && bytes.size() >= 4) {
      const std::uint32_t checksum = crc32c(std::span<const std::byte>(bytes).first(bytes.size() - 4));
      std::memcpy(bytes.data() + bytes.size() - 4, &checksum, sizeof checksum);
    }
    require(decoder.push(record.bytes, now_ns), "there is room");
    while (decoder.pop(event)) {
      require_frame(event, set);
      if (event.kind == SourceEventKind::kFrame) {
        require(event.frame.count == set->names.size() || event.frame.header.set_id != set->id, "a frame fits its set");
        require(window.push(event.frame), "there is room");
      }
      if (event.kind == SourceEventKind::kEndOfStream) window.end_of_stream(event.end.last_sequence);
      while (window.pop(frame)) {
      }
    }
    window.tick({.time_ns = now_ns});
    while (window.pop(frame)) {
    }
    require_balance(decoder);
    require(window.ledger().balanced(), "the window's ledger balances");
  }
  decoder.flush();
  while (decoder.pop(event)) {
  }
  require_balance(decoder);
  require(decoder.counters().datagrams.held.value() == 0, "nothing is held after a flush");
}

std::vector<Bytes> native_seeds() {
  DatagramBuffer buffer;
  Bytes one, split;
  const auto add = [&](std::size_t size, Bytes& input) {
    append_record(0x40, std::span<const std::byte>(buffer).first(size), input);
  };
  for (const std::size_t count : {std::size_t{3}, std::size_t{130}}) {
    Bytes& input = count == 3 ? one : split;
    MarkerSet set{.id = 1, .names = {}, .rate_hz = 100};
    for (std::size_t i = 0; i < count; ++i) set.names.push_back(fmt::format("m{}", i));
    add(encode(set, 9, 0, 0, buffer).bytes, input);
    for (std::uint64_t s = 0; s < 3; ++s) {
      MarkerFrame frame;
      frame.header.set_id = 1;
      frame.header.sequence = s;
      frame.header.capture_time_ns = static_cast<std::int64_t>(s) * 10 * kMs;
      frame.count = static_cast<std::uint32_t>(count);
      frame.state.fill(MarkerState::kMeasured);
      for (std::size_t next = 0; next < count;) {
        const EncodedPart part = encode(frame, 9, next, buffer);
        add(part.bytes, input);
        next = part.next;
      }
    }
    add(encode(EndOfStream{.session = 9, .frames_sent = 3, .last_sequence = 2}, buffer), input);
  }
  return {one, split};
}

void run_live_link(std::span<const std::byte> input) {
  LiveLinkSession session({.event_capacity = 3});
  ReorderWindowOf<ShapeFrame> window;
  SourceEvent event;
  ShapeFrame frame;
  std::int64_t now_ns = kBeginNs;
  for (Record record; take_record(input, record);) {
    now_ns += pause_ns(record.control);
    require(session.push(record.bytes, now_ns), "there is room");
    while (session.pop(event)) {
      if (event.kind == SourceEventKind::kShapes) require(window.push(event.shapes), "there is room");
      while (window.pop(frame)) {
      }
    }
    require_balance(session);
  }
}

std::vector<Bytes> live_link_seeds() {
  Bytes input;
  for (std::int32_t i = 0; i < 3; ++i) {
    LiveLinkPacket packet{.device_id = "$01234567-89AB-CDEF-0123-456789ABCDEF", .name = "iPhone", .frame = 100 + i};
    packet.has_face = i < 2;
    packet.value.fill(0.5F);
    ByteAppender out;
    encode_live_link(packet, out);
    append_record(0x40, out.bytes(), input);
  }
  return {input};
}

void run_natnet(std::span<const std::byte> input) {
  NatnetSession session({.event_capacity = 8});
  SourceEvent event;
  NatnetDatagram datagram;
  ClockSample sample;
  const MarkerSet* set = nullptr;
  std::int64_t now_ns = kBeginNs;
  session.tick({.time_ns = now_ns});
  for (Record record; take_record(input, record);) {
    now_ns += pause_ns(record.control);
    session.tick({.time_ns = now_ns});
    require(session.push(record.bytes, now_ns), "there is room");
    while (session.pop_datagram(datagram)) {
    }
    while (session.pop(event)) require_frame(event, set);
    session.pop_clock_sample(sample);
    require_balance(session);
  }
}

std::vector<Bytes> natnet_seeds() {
  std::vector<Bytes> seeds;
  for (const NatnetVersion version : {NatnetVersion{3, 0}, NatnetVersion{4, 1}}) {
    Bytes input;
    NatnetDatagram out;
    const auto add = [&] { append_record(0x40, out, input); };
    encode_server_info({.name = "Motive", .version = version, .clock_frequency = 10'000'000, .data_port = 1511}, out);
    add();
    encode_response(240.0F, out);
    add();
    encode_model(
        std::vector<NatnetAsset>{{.name = "face", .id = {}, .marker_names = {"brow", "chin"}, .marker_ids = {}}},
        version, out);
    add();
    const std::vector<NatnetLabelledMarker> markers{{.id = 1, .x = 1}, {.id = 2, .y = 1}};
    for (std::int32_t i = 0; i < 3; ++i) {
      encode_frame(
          {.frame_number = 7 + i,
           .marker_set = "face",
           .markers = markers,
           .suffix = {.timestamp_s = 1 + 0.01 * i, .mid_exposure_ticks = 20'000'000u + 100'000u * unsigned(i)}},
          version, out);
      add();
    }
    encode_echo_response({.client_ticks = 5, .host_ticks = 6}, out);
    add();
    seeds.push_back(input);
  }
  return seeds;
}

namespace {

/// What is said to a session of a stream of bytes: pieces of it, datagrams, breaks of the connection.
void converse(TrackerSession& session, std::span<const std::byte> input) {
  constexpr unsigned kDatagram = 1, kBreak = 2;
  SourceEvent event;
  const MarkerSet* set = nullptr;
  std::int64_t now_ns = kBeginNs;
  session.connected(now_ns);
  Bytes unread;
  for (Record record; take_record(input, record);) {
    now_ns += pause_ns(record.control);
    if ((record.control & kBreak) != 0 || session.failed()) {
      session.disconnected();
      unread.clear();
      session.connected(now_ns);
    }
    session.tick(now_ns);
    if ((record.control & kDatagram) != 0) {
      session.receive_datagram(record.bytes, now_ns);
    } else {
      unread.insert(unread.end(), record.bytes.begin(), record.bytes.end());
    }
    // The session takes no more than there is room for, and is asked again when its events are taken.
    for (std::size_t used = 1; used > 0 && !session.failed();) {
      const Bytes exact(unread);
      used = session.receive(exact, now_ns);
      require(used <= exact.size(), "no more is used than there is");
      unread.erase(unread.begin(), unread.begin() + static_cast<std::ptrdiff_t>(used));
      while (session.pop(event)) require_frame(event, set);
    }
    session.outbox().clear();
    require_balance(session);
  }
  session.disconnected();
  session.flush();
  while (session.pop(event)) {
  }
  require_balance(session);
}

}  // namespace

void run_qtm(std::span<const std::byte> input) {
  QtmSession session({.tracker = {.event_capacity = 16}, .label_prefix = {}});
  if (!input.empty() && (input[0] & std::byte{4}) != std::byte{0}) session.use_udp_port(5000);
  converse(session, input);
}

std::vector<Bytes> qtm_seeds() {
  ByteAppender out;
  append_qtm_text(QtmPacketType::kCommand, "QTM RT Interface connected", out);
  append_qtm_text(QtmPacketType::kCommand, "Version set to 1.13", out);
  append_qtm_text(QtmPacketType::kXml,
                  print_qtm_settings({.labels = std::vector<std::string>{"chin", "nose"},
                                      .frequency_hz = 120,
                                      .timecode_rate_hz = {},
                                      .axis_upwards = "+Z"},
                                     "1.13"),
                  out);
  append_qtm_event(QtmEvent::kCaptureStarted, out);
  Bytes input, frames;
  append_record(0x40, out.bytes(), input);
  const std::vector<std::optional<std::array<float, 3>>> positions{std::array<float, 3>{1, 2, 3}, std::nullopt};
  for (std::uint32_t i = 0; i < 3; ++i) {
    out.clear();
    append_qtm_data(i * 10'000, i, {.markers = true, .timecode = true}, positions, Timecode{1, 2, 3, 4, 30}, out);
    append_record(0x40 + (i == 2 ? 1 : 0), out.bytes(), input);
  }
  out.clear();
  append_qtm_no_more_data(out);
  append_record(0x40, out.bytes(), input);
  return {input};
}

void run_vicon(std::span<const std::byte> input) {
  ViconSession session({.tracker = {.event_capacity = 16}, .subject = {}});
  converse(session, input);
}

std::vector<Bytes> vicon_seeds() {
  Bytes input;
  const auto add = [&](auto write) {
    ByteAppender out;
    ViconPacketWriter writer(out);
    write(writer);
    writer.finish();
    append_record(0x40, out.bytes(), input);
  };
  const std::vector<std::uint32_t> ids{1, 2, 5, 6, 7, 23, 26, 37, 39, 40, 42, 100004};
  add([&](auto& p) { p.ids(ViconId::kObjectEnums, ids); });
  for (std::uint32_t i = 0; i < 3; ++i) {
    add([&](auto& p) {
      p.i64(ViconId::kStreamInfo, 1125000);
      p.subject({.id = 7, .name = "face", .markers = {{10, "chin"}, {11, "nose"}}});
      p.u8(ViconId::kApplicationInfo, 0);
      p.u32(ViconId::kFrameInfo, i);
      p.labelled(std::vector<ViconRecon>{{7, 10, {1, 2, 3}}, {7, 11, {4, 5, 6}}});
    });
  }
  return {input};
}

}  // namespace risorius::fuzz
