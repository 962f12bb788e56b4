#include "capture/wire/vicon_packet_writer.h"

#include <array>

namespace risorius {
namespace {

constexpr std::size_t kCovarianceBytes = 9 * 8;

std::uint32_t standard_of(const Timecode& timecode) noexcept {
  if (timecode.drop_frame) return 2;
  if (timecode.frame_rate == 25) return 0;
  return timecode.frame_rate == 24 ? 3 : 1;
}

}  // namespace

ViconPacketWriter::ViconPacketWriter(ByteAppender& out) : out_(out), start_(out.size()) {
  out_.append(kViconTag);
  out_.append(std::uint32_t{0});
}

void ViconPacketWriter::finish() {
  out_.patch(start_ + 4, static_cast<std::uint32_t>(out_.size() - start_ - kViconHeaderBytes));
}

template <class Body>
void ViconPacketWriter::object(ViconId id, Body body) {
  const std::size_t at = out_.size();
  out_.append(static_cast<std::uint32_t>(id));
  out_.append(std::uint32_t{0});
  body();
  out_.patch(at + 4, static_cast<std::uint32_t>(out_.size() - at - kViconHeaderBytes));
}

void ViconPacketWriter::text(std::string_view text) {
  out_.append(static_cast<std::uint32_t>(text.size()));
  out_.append_text(text);
}

void ViconPacketWriter::ids(ViconId id, std::span<const std::uint32_t> ids) {
  object(id, [&] {
    out_.append(static_cast<std::uint32_t>(ids.size()));
    for (const std::uint32_t one : ids) out_.append(one);
  });
}

void ViconPacketWriter::contents(std::span<const std::pair<std::uint32_t, std::uint32_t>> counts,
                                 std::span<const std::uint32_t> unchanged) {
  object(ViconId::kContents, [&] {
    out_.append(static_cast<std::uint32_t>(counts.size()));
    for (const auto& [id, count] : counts) {
      out_.append(id);
      out_.append(count);
    }
    out_.append(static_cast<std::uint32_t>(unchanged.size()));
    for (const std::uint32_t id : unchanged) out_.append(id);
  });
}

void ViconPacketWriter::subject(const ViconSubject& subject) {
  object(ViconId::kSubjectInfo, [&] {
    out_.append(subject.id);
    text(subject.name);
    out_.append(std::uint32_t{0});  // segments
    out_.append(static_cast<std::uint32_t>(subject.markers.size()));
    for (const auto& marker : subject.markers) {
      out_.append(marker.id);
      text(marker.name);
    }
    out_.append(std::uint32_t{0});  // attachments
  });
}

void ViconPacketWriter::timecode(const Timecode& timecode) {
  object(ViconId::kTimecode, [&] {
    for (const std::uint8_t field : {timecode.hours, timecode.minutes, timecode.seconds, timecode.frames})
      out_.append(field);
    out_.append(std::uint16_t{0});
    out_.append(std::uint16_t{1});
    out_.append(standard_of(timecode));
    out_.append(std::uint32_t{0});
    out_.append(std::uint8_t{0});
  });
}

void ViconPacketWriter::labelled(std::span<const ViconRecon> recons) {
  constexpr std::array<std::byte, kCovarianceBytes> kNoCovariance{};
  object(ViconId::kLabeledRecons, [&] {
    out_.append(static_cast<std::uint32_t>(recons.size()));
    std::uint32_t trajectory = 0;
    for (const ViconRecon& recon : recons) {
      out_.append(recon.subject);
      out_.append(recon.marker);
      out_.append(0.0);
      for (const double axis : recon.position_mm) out_.append(axis);
      out_.append_bytes(kNoCovariance);
      out_.append(++trajectory);
    }
  });
}

void ViconPacketWriter::no_unlabelled() {
  object(ViconId::kUnlabeledRecons, [&] { out_.append(std::uint32_t{0}); });
}

void ViconPacketWriter::latencies(std::span<const std::pair<std::string_view, double>> seconds) {
  object(ViconId::kLatencyInfo, [&] {
    out_.append(static_cast<std::uint32_t>(seconds.size()));
    for (const auto& [name, value] : seconds) {
      text(name);
      out_.append(value);
    }
  });
}

void ViconPacketWriter::frame_rate(std::string_view name, double hz) {
  object(ViconId::kFrameRateInfo, [&] {
    out_.append(std::uint32_t{1});
    text(name);
    out_.append(hz);
  });
}

void ViconPacketWriter::i64(ViconId id, std::int64_t value) {
  object(id, [&] { out_.append(value); });
}
void ViconPacketWriter::u32(ViconId id, std::uint32_t value) {
  object(id, [&] { out_.append(value); });
}
void ViconPacketWriter::u8(ViconId id, std::uint8_t value) {
  object(id, [&] { out_.append(value); });
}

}  // namespace risorius
