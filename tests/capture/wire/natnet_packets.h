// NatNet messages as trackers send them, written by hand from the layouts in capture/README.md.
#pragma once

#include "capture/wire/natnet_codec.h"
#include "support/hand_packet.h"

namespace risorius::test {

inline HandPacket natnet_message(unsigned id, const HandPacket& payload) {
  return HandPacket().u16(id).u16(static_cast<unsigned>(payload.size())).packet(payload);
}

/// From 4.1 on sections have their size behind their count.
inline HandPacket natnet_section(std::int32_t count, const HandPacket& data, bool sized) {
  HandPacket section;
  section.i32(count);
  if (sized) section.i32(static_cast<std::int32_t>(data.size()));
  return section.packet(data);
}

inline HandPacket natnet_labelled(int model, int member, float x, float y, float z, int params) {
  return HandPacket().i32((model << 16) | member).f32({x, y, z, 0.004f}).i16(params).f32({0.0f});
}

inline HandPacket natnet_rigid_body(int id) { return HandPacket().i32(id).f32({1, 2, 3, 0, 0, 0, 1, 0.001f}).i16(1); }

struct NatnetHandFrame {
  std::int32_t number = 7;
  bool sized = true;
  HandPacket marker_sets = HandPacket();
  int marker_set_count = 0;
  HandPacket labelled = HandPacket();
  int labelled_count = 0;
  HandPacket extra = HandPacket();  ///< between devices and suffix
  HandPacket trailing = HandPacket();
  std::uint32_t timecode = 0, timecode_sub = 0;
  double timestamp_s = 1.5;
  std::uint64_t ticks = 20'000'000;
  int params = 0;

  HandPacket payload() const {
    const HandPacket plate = HandPacket().i32(9).i32(2).i32(1).f32({0.5f}).i32(3).f32({1, 2, 3});
    HandPacket p;
    p.i32(number).packet(natnet_section(marker_set_count, marker_sets, sized));
    p.packet(natnet_section(2, HandPacket().f32({1, 2, 3, 4, 5, 6}), sized));  // unlabelled
    p.packet(natnet_section(1, natnet_rigid_body(4), sized));
    p.packet(natnet_section(1, HandPacket().i32(5).i32(1).packet(natnet_rigid_body(6)), sized));  // skeleton
    if (sized)
      p.packet(natnet_section(
          1, HandPacket().i32(8).i32(1).packet(natnet_rigid_body(2)).i32(1).packet(natnet_labelled(8, 1, 1, 1, 1, 2)),
          sized));  // asset
    p.packet(natnet_section(labelled_count, labelled, sized));
    p.packet(natnet_section(1, plate, sized)).packet(natnet_section(1, plate, sized)).packet(extra);  // and device
    p.u32(timecode).u32(timecode_sub).f64(timestamp_s).u64(ticks).u64(ticks + 10).u64(ticks + 20);
    if (sized) p.u32(0).u32(0);
    return p.i16(params).i32(0).packet(trailing);
  }
  std::vector<std::byte> datagram() const { return natnet_message(7, payload()).bytes(); }
};

/// One marker set "face" of three markers, the second occluded, and an unlabelled one.
inline NatnetHandFrame natnet_face_frame(bool sized, std::int32_t number = 7) {
  NatnetHandFrame frame{.number = number, .sized = sized};
  frame.marker_sets.text("face").i32(3).f32({0.1f, 0.2f, 0.3f, 0, 0, 0, 0.7f, 0.8f, 0.9f});
  frame.marker_set_count = 1;
  frame.labelled.packet(natnet_labelled(1, 1, 0.1f, 0.2f, 0.3f, 0x0A))
      .packet(natnet_labelled(1, 2, 0.4f, 0.5f, 0.6f, 0x09))
      .packet(natnet_labelled(1, 3, 0.7f, 0.8f, 0.9f, 0x0A))
      .packet(natnet_labelled(0, 50000, 9, 9, 9, 0x12));
  frame.labelled_count = 4;
  return frame;
}

inline std::vector<std::byte> natnet_server_info(unsigned major, unsigned minor,
                                                 std::uint64_t clock_frequency = 10'000'000, unsigned app_major = 2) {
  HandPacket payload;
  payload.text("Motive").zeros(256 - 7).u8(app_major).u8(3).u8(0).u8(1).u8(major).u8(minor).u8(0).u8(0);
  payload.u64(clock_frequency).u16(1511).u8(0).u8(239).u8(255).u8(42).u8(99);
  return natnet_message(1, payload).bytes();
}

/// A model definition, description by description.
struct NatnetHandModel {
  bool sized = true;
  HandPacket descriptions = HandPacket();
  int count = 0;

  NatnetHandModel& add(int type, const HandPacket& description) {
    descriptions.i32(type);
    if (sized) descriptions.i32(static_cast<std::int32_t>(description.size()));
    descriptions.packet(description);
    ++count;
    return *this;
  }
  NatnetHandModel& marker_set(std::string_view name, std::initializer_list<std::string_view> markers) {
    HandPacket set;
    set.text(name).i32(static_cast<std::int32_t>(markers.size()));
    for (const auto marker : markers) set.text(marker);
    return add(0, set);
  }
  HandPacket payload() const { return HandPacket().i32(count).packet(descriptions); }
  std::vector<std::byte> datagram() const { return natnet_message(5, payload()).bytes(); }
};

}  // namespace risorius::test
