#include "capture/wire/qtm_codec.h"

#include <gtest/gtest.h>
#include <random>

#include "capture/wire/qtm_settings.h"
#include "support/allocation_counter.h"
#include "support/hex.h"

namespace risorius {
namespace {

using test::bytes_of;
using test::hex;
using test::operator+;
using Bytes = std::vector<std::byte>;

constexpr std::size_t kLimit = 1 << 20;

// Written by hand from the layout in capture/README.md.
const char* const kFrame =
    "40000000 03000000"            // 64 bytes, data
    "A0860100 00000000 2A000000"   // 100000 us, frame 42
    "01000000"                     // one component
    "28000000 01000000"            // 40 bytes, 3D
    "02000000 0500 0700"           // two markers; 5 and 7 per mille
    "0000803F 00000040 00004040"   // 1, 2, 3
    "FFFFFFFF FFFFFFFF FFFFFFFF";  // not seen
const char* const kHead = "A0860100 00000000 2A000000";

/// Views, and the bytes that they look at.
struct Decoded : QtmData {
  Bytes bytes;
};

Decoded decoded(Bytes body) {
  Decoded decoded;
  decoded.bytes = std::move(body);
  EXPECT_EQ(decode_qtm_data(decoded.bytes, decoded), QtmError::kNone);
  return decoded;
}

QtmError error_of(const Bytes& body) {
  QtmData data;
  return decode_qtm_data(body, data);
}

TEST(QtmCodec, ReadsFrameWrittenByHand) {
  const Bytes stream = hex(kFrame) + hex("0B");
  std::span<const std::byte> bytes = stream;
  QtmPacket packet;
  ASSERT_EQ(take_qtm_packet(bytes, kLimit, packet), PacketStatus::kWhole);
  EXPECT_EQ(packet.type, QtmPacketType::kData);
  EXPECT_EQ(bytes.size(), 1u);
  QtmData data;
  ASSERT_EQ(decode_qtm_data(packet.body, data), QtmError::kNone);
  EXPECT_EQ(data.timestamp_us, 100000u);
  EXPECT_EQ(data.frame, 42u);
  ASSERT_TRUE(data.labelled);
  EXPECT_FALSE(data.unlabelled || data.timecode);
  EXPECT_EQ(data.labelled->count, 2u);
  EXPECT_EQ(data.labelled->drop_rate_per_mille, 5);
  EXPECT_EQ(data.labelled->out_of_sync_rate_per_mille, 7);
  EXPECT_EQ(data.labelled->position(0), (std::array<float, 3>{1, 2, 3}));
  EXPECT_FALSE(data.labelled->position(1));
}

TEST(QtmCodec, TakesAnyNumberThatIsNoneForNotSeen) {
  // One coordinate is another NaN, one infinite.
  const Decoded data = decoded(hex(kHead) + hex("01000000 28000000 01000000 02000000 0000 0000"
                                                "0000803F 0100807F 00004040 0000803F 00000040 0000807F"));
  EXPECT_FALSE(data.labelled->position(0));
  EXPECT_FALSE(data.labelled->position(1));
}

TEST(QtmCodec, ReadsAllFourKindsOfMarkers) {
  const auto residual = decoded(hex(kHead) + hex("01000000 20000000 09000000 01000000 0000 0000"
                                                 "0000803F 00000040 00004040 0000003F"));
  EXPECT_EQ(residual.labelled->position(0), (std::array<float, 3>{1, 2, 3}));
  const auto no_labels = decoded(hex(kHead) + hex("01000000 20000000 02000000 01000000 0000 0000"
                                                  "0000803F 00000040 00004040 63000000"));
  EXPECT_FALSE(no_labels.labelled);
  EXPECT_EQ(no_labels.unlabelled->position(0), (std::array<float, 3>{1, 2, 3}));
  const auto both = decoded(hex(kHead) + hex("01000000 24000000 0A000000 01000000 0000 0000"
                                             "0000803F 00000040 00004040 63000000 0000003F"));
  EXPECT_EQ(both.unlabelled->count, 1u);
  EXPECT_EQ(both.unlabelled->position(0), (std::array<float, 3>{1, 2, 3}));
}

TEST(QtmCodec, SkipsOtherComponentsSurplusBytesAndEmptyBodies) {
  const Decoded data = decoded(hex(kHead) + hex("04000000"
                                                "0C000000 12000000 DEADBEEF"            // a skeleton
                                                "08000000 02000000"                     // 3DNoLabels without a body
                                                "08000000 11000000"                     // timecode without a body
                                                "20000000 01000000 01000000 0000 0000"  // a marker and 4 bytes more
                                                "0000803F 00000040 00004040 DEADBEEF"
                                                "CAFE"));  // behind the last component
  EXPECT_EQ(data.other_components, 1u);
  EXPECT_FALSE(data.unlabelled || data.timecode);
  EXPECT_EQ(data.labelled->position(0), (std::array<float, 3>{1, 2, 3}));
}

TEST(QtmCodec, RefusesComponentsThatCannotBe) {
  // Of size zero: it would never end.
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 00000000 01000000")), QtmError::kBadComponent);
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 07000000 01000000")), QtmError::kBadComponent);
  // One byte past the end.
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 11000000 01000000 00000000 0000 0000")), QtmError::kBadComponent);
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 FFFFFFFF 01000000 00000000 0000 0000")), QtmError::kBadComponent);
  // More components than there are, by one and by four thousand million.
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000")), QtmError::kBadComponent);
  EXPECT_EQ(error_of(hex(kHead) + hex("FFFFFFFF 08000000 12000000")), QtmError::kBadComponent);
  // More markers than bytes; a count whose product would wrap around.
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 10000000 01000000 01000000 0000 0000")), QtmError::kBadCount);
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 10000000 01000000 56555515 0000 0000")), QtmError::kBadCount);
  EXPECT_EQ(error_of(hex(kHead) + hex("01000000 0C000000 11000000 01000000")), QtmError::kBadCount);
}

TEST(QtmCodec, KnowsAPacketsEndOnlyFromItsHeader) {
  const Bytes whole = hex(kFrame);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::span<const std::byte> cut = std::span(whole).first(size);
    QtmPacket packet;
    ASSERT_EQ(take_qtm_packet(cut, kLimit, packet), PacketStatus::kIncomplete) << size;
    ASSERT_EQ(cut.size(), size);
    ASSERT_NE(read_qtm_datagram(cut, packet), QtmError::kNone);
  }
  const auto status_of = [](const Bytes& bytes) {
    std::span<const std::byte> span = bytes;
    QtmPacket packet;
    return take_qtm_packet(span, 1000, packet);
  };
  EXPECT_EQ(status_of(hex("00000000 03000000")), PacketStatus::kBad);
  EXPECT_EQ(status_of(hex("07000000 03000000")), PacketStatus::kBad);
  EXPECT_EQ(status_of(hex("E9030000 03000000")), PacketStatus::kBad);  // 1001
  EXPECT_EQ(status_of(hex("FFFFFFFF 03000000")), PacketStatus::kBad);
  EXPECT_EQ(status_of(hex("E8030000 03000000")), PacketStatus::kIncomplete);
  EXPECT_EQ(status_of(hex("08000000 04000000")), PacketStatus::kWhole);
}

TEST(QtmCodec, RefusesEveryTruncationOfAFrameEvenIfItsSizeIsMended) {
  const Bytes copy = hex(kFrame);
  for (std::size_t size = 8; size < copy.size(); ++size) {
    const Bytes cut(copy.begin() + 8, copy.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(error_of(cut), QtmError::kNone) << size;
  }
}

TEST(QtmCodec, ReadsTextsWithAndWithoutTheirEnd) {
  EXPECT_EQ(qtm_text(bytes_of(std::string_view("QTM RT Interface connected\0", 27))), "QTM RT Interface connected");
  EXPECT_EQ(qtm_text(bytes_of("no end")), "no end");
  EXPECT_EQ(qtm_text(bytes_of(std::string_view("a\0b\0", 4))), "a");
  EXPECT_EQ(qtm_text({}), "");
}

TEST(QtmCodec, ReadsEvents) {
  EXPECT_EQ(qtm_event(hex("03")), QtmEvent::kCaptureStarted);
  EXPECT_EQ(qtm_event(hex("0C")), QtmEvent::kShuttingDown);
  EXPECT_FALSE(qtm_event({}));
  EXPECT_FALSE(qtm_event(hex("00")));
  EXPECT_FALSE(qtm_event(hex("11")));
}

TEST(QtmCodec, ReadsTimecodesOfAllThreeKinds) {
  // 21:43:05:17 is 21 | 43 << 5 | 5 << 11 | 17 << 17 = 0x00222D75; a subframe stands above bit 22.
  const auto smpte = decoded(hex(kHead) + hex("01000000 18000000 11000000 01000000 00000000 00000000 752DE200"));
  ASSERT_TRUE(smpte.timecode);
  const auto clock = smpte.timecode->clock(25);
  ASSERT_TRUE(clock);
  EXPECT_EQ(clock->hours, 21);
  EXPECT_EQ(clock->minutes, 43);
  EXPECT_EQ(clock->seconds, 5);
  EXPECT_EQ(clock->frames, 17);
  EXPECT_EQ(clock->frame_rate, 25);
  EXPECT_FALSE(smpte.timecode->clock(15)) << "a frame 17 of 15";
  const QtmTimecode irig{.type = 1, .high = 26 | 300 << 7, .low = 21 | 43 << 5 | 5 << 11 | 9 << 17};
  EXPECT_EQ(irig.clock(25)->frames, 9);
  EXPECT_EQ(irig.clock(25)->frame_rate, 10);
  EXPECT_FALSE((QtmTimecode{.type = 2, .high = 1, .low = 21}).clock(25));
  EXPECT_FALSE((QtmTimecode{.type = 0, .low = 24}).clock(25)) << "24 o'clock";
  EXPECT_FALSE(decoded(hex(kHead) + hex("01000000 0C000000 11000000 00000000")).timecode);
}

TEST(QtmCodec, WritesTheBytesOfTheSpecification) {
  ByteAppender out;
  const std::array<std::optional<std::array<float, 3>>, 2> positions{std::array<float, 3>{1, 2, 3}, std::nullopt};
  append_qtm_data(100000, 42, {.markers = true}, positions, {}, out);
  const auto of = [](std::span<const std::byte> span) { return Bytes(span.begin(), span.end()); };
  // All but the drop rates, which a server of a file does not have.
  Bytes without_rates = hex(kFrame);
  for (std::size_t i = 36; i < 40; ++i) without_rates[i] = std::byte{0};
  EXPECT_EQ(of(out.bytes()), without_rates);
  out.clear();
  append_qtm_text(QtmPacketType::kCommand, "Hi", out);
  EXPECT_EQ(of(out.bytes()), hex("0B000000 01000000 48 69 00"));
  out.clear();
  append_qtm_event(QtmEvent::kCaptureStarted, out);
  EXPECT_EQ(of(out.bytes()), hex("09000000 06000000 03"));
  out.clear();
  append_qtm_no_more_data(out);
  EXPECT_EQ(of(out.bytes()), hex("08000000 04000000"));
}

TEST(QtmCodec, ReadsBackWhatItWrites) {
  ByteAppender out;
  const std::array<std::optional<std::array<float, 3>>, 2> positions{std::nullopt, std::array<float, 3>{-1, 2e-30F, 3}};
  const QtmComponents all{
      .markers = true, .residuals = true, .unlabelled = true, .unlabelled_residuals = true, .timecode = true};
  append_qtm_data(7, 8, all, positions, Timecode{23, 59, 58, 29, 30}, out);
  std::span<const std::byte> bytes = out.bytes();
  QtmPacket packet;
  ASSERT_EQ(take_qtm_packet(bytes, kLimit, packet), PacketStatus::kWhole);
  EXPECT_TRUE(bytes.empty());
  QtmData data;
  ASSERT_EQ(decode_qtm_data(packet.body, data), QtmError::kNone);
  EXPECT_FALSE(data.labelled->position(0));
  EXPECT_EQ(data.labelled->position(1), positions[1]);
  EXPECT_EQ(data.unlabelled->count, 0u);
  EXPECT_EQ(data.timecode->clock(30)->seconds, 58);
  EXPECT_EQ(data.timecode->clock(30)->frames, 29);
}

TEST(QtmCodec, SurvivesMutationsWithoutAllocating) {
  ByteAppender out;
  const std::array<std::optional<std::array<float, 3>>, 3> positions{};
  const QtmComponents all{
      .markers = true, .residuals = true, .unlabelled = true, .unlabelled_residuals = true, .timecode = true};
  append_qtm_data(7, 8, all, positions, Timecode{23, 59, 58, 29, 30}, out);
  const Bytes good(out.bytes().begin(), out.bytes().end());
  std::mt19937_64 random(20);
  std::size_t accepted = 0, read = 0;
  Bytes bytes = good;
  const auto before = test::allocations_of_this_thread();
  for (int i = 0; i < 40000; ++i) {
    std::copy(good.begin(), good.end(), bytes.begin());
    for (std::uint64_t changes = 1 + random() % 4; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 3 == 0 ? 0xFF : random());
    const std::size_t size = random() % 4 == 0 ? random() % (bytes.size() + 1) : bytes.size();
    std::span<const std::byte> span = std::span(bytes).first(size);
    QtmPacket packet;
    if (take_qtm_packet(span, kLimit, packet) != PacketStatus::kWhole) continue;
    QtmData data;
    if (decode_qtm_data(packet.body, data) != QtmError::kNone) continue;
    ++accepted;
    for (const auto& markers : {data.labelled, data.unlabelled})
      for (std::size_t m = 0; markers && m < markers->count; ++m) read += markers->position(m) ? 1 : 0;
    if (data.timecode) read += data.timecode->clock(30) ? 1 : 0;
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
  EXPECT_GT(accepted, 1000u);
  EXPECT_LT(accepted, 39000u);
  EXPECT_GT(read, 0u);
}

TEST(QtmSettings, ReadsLabelsAxisAndRates) {
  const auto settings = parse_qtm_settings(
      "<QTM_Parameters_Ver_1.13>\r\n <General><Frequency>240</Frequency><Camera><ID>1</ID></Camera>"
      "<External_Timestamp><Enabled>True</Enabled><Type>SMPTE</Type><Frequency>25</Frequency></External_Timestamp>"
      "</General><The_3D><AxisUpwards>+Z</AxisUpwards><CalibrationTime/><Labels>9</Labels>"
      "<Label><Name>brow &amp; lid</Name><RGBColor>1</RGBColor></Label><Label><RGBColor>1</RGBColor>"
      "<Name>Kinn \xC3\xA4</Name></Label><Bones/></The_3D></QTM_Parameters_Ver_1.13>");
  ASSERT_TRUE(settings && settings->labels);
  EXPECT_EQ(*settings->labels, (std::vector<std::string>{"brow & lid", "Kinn \xC3\xA4"}));
  EXPECT_EQ(settings->frequency_hz, 240);
  EXPECT_EQ(settings->timecode_rate_hz, 25);
  EXPECT_EQ(settings->axis_upwards, "+Z");
}

TEST(QtmSettings, SurvivesWhatIsMissingOrBroken) {
  EXPECT_FALSE(parse_qtm_settings("<a><b></a>"));
  EXPECT_FALSE(parse_qtm_settings(""));
  const auto none = parse_qtm_settings("<QTM_Parameters_Ver_1.13><The_6D/></QTM_Parameters_Ver_1.13>");
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->labels || none->frequency_hz);
  const auto empty = parse_qtm_settings("<x><General><Frequency>-5</Frequency></General><The_3D/></x>");
  EXPECT_TRUE(empty->labels && empty->labels->empty());
  EXPECT_FALSE(empty->frequency_hz);
}

TEST(QtmSettings, ReadsBackWhatItWrites) {
  const QtmSettings settings{.labels = std::vector<std::string>{"a<b", "\"c\"", ""},
                             .frequency_hz = 120,
                             .timecode_rate_hz = 30,
                             .axis_upwards = "+Y"};
  const auto again = parse_qtm_settings(print_qtm_settings(settings, "1.13"));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->labels, settings.labels);
  EXPECT_EQ(again->frequency_hz, settings.frequency_hz);
  EXPECT_EQ(again->timecode_rate_hz, settings.timecode_rate_hz);
  EXPECT_EQ(again->axis_upwards, "+Y");
  EXPECT_EQ(print_qtm_settings(settings, "1.13").find("<QTM_Parameters_Ver_1.13>"), 0u);
}

TEST(QtmSettings, HasAllThatClientsOfTheVendorInsistOn) {
  const std::string xml = print_qtm_settings(
      {.labels = std::vector<std::string>{"chin"}, .frequency_hz = 120, .axis_upwards = "+Y"}, "1.27");
  std::size_t at = 0;
  for (const char* element : {"<General>", "<External_Time_Base>", "<Processing_Actions>", "<PreProcessing2D>",
                              "<TwinSystemMerge>", "<ExportAviFile>", "<RealTime_Processing_Actions>", "<GazeVector>",
                              "<Reprocessing_Actions>", "<SplineFill>", "</General>", "<CalibrationTime>"}) {
    at = xml.find(element, at);
    ASSERT_NE(at, std::string::npos) << element << " is missing or in another place\n" << xml;
  }
  EXPECT_EQ(xml.find("<CalibrationTime></CalibrationTime>"), std::string::npos);
  EXPECT_EQ(xml.find("<CalibrationTime />"), std::string::npos);
}

TEST(QtmSettings, SurvivesMutations) {
  const std::string good = print_qtm_settings(
      {.labels = std::vector<std::string>{"a<b", "c"}, .frequency_hz = 120, .axis_upwards = "+Y"}, "1.13");
  std::mt19937_64 random(21);
  std::size_t accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bad = good;
    for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes)
      bad[random() % bad.size()] = static_cast<char>(random());
    if (random() % 4 == 0) bad.resize(random() % bad.size());
    accepted += parse_qtm_settings(bad) ? 1 : 0;
  }
  EXPECT_GT(accepted, 100u);
  EXPECT_LT(accepted, 19900u);
}

}  // namespace
}  // namespace risorius
