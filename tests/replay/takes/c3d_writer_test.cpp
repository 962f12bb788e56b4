#include "replay/takes/c3d_writer.h"

#include <gtest/gtest.h>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "replay/takes/c3d_reader.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::read_all;

class C3dWriterTest : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "take.c3d";
};

TEST_F(C3dWriterTest, IsReadBackWithEqualBits) {
  constexpr std::size_t kMarkers = 41;
  {
    C3dWriter writer(path_, test::sample_set(kMarkers, 119.88), "0.1.0");
    for (std::uint64_t f = 0; f < 50; ++f) writer.write(test::sample_frame(f, kMarkers));
    writer.finish();
  }
  C3dReader reader(path_, {});
  EXPECT_TRUE(reader.info().warnings.empty());
  EXPECT_EQ(reader.info().markers.names, test::sample_set(kMarkers).names);
  EXPECT_EQ(reader.info().frame_count, 50u);
  const auto frames = read_all(reader);
  for (std::uint64_t f = 0; f < 50; ++f) {
    EXPECT_EQ(frames[f].position_mm, test::sample_frame(f, kMarkers).position_mm);
    EXPECT_EQ(frames[f].state, test::sample_frame(f, kMarkers).state);
    EXPECT_EQ(frames[f].header.capture_time_ns, capture_time_of(f, 119.88));
  }
}

TEST_F(C3dWriterTest, WritesTheHeaderWordsThatTheFormatAsksFor) {
  test::write_c3d(path_, 3, 2);
  const std::string bytes = test::read_bytes(path_);
  const auto word = [&](std::size_t number) {  // the format counts words from 1
    return static_cast<unsigned char>(bytes[2 * number - 2]) | (static_cast<unsigned char>(bytes[2 * number - 1]) << 8);
  };
  EXPECT_EQ(word(1), 0x5002);
  EXPECT_EQ(word(2), 3);  // points
  EXPECT_EQ(word(3), 0);  // analog values
  EXPECT_EQ(word(4), 1);  // first frame
  EXPECT_EQ(word(5), 2);  // last frame
  EXPECT_EQ(word(7), 0);  // words 7-8: -1.0f = BF800000, low word first
  EXPECT_EQ(word(8), 0xBF80);
  EXPECT_EQ(word(10), 0);
  EXPECT_EQ(word(11), 0);  // words 11-12: 120.0f = 42F00000
  EXPECT_EQ(word(12), 0x42F0);
  // The parameter section: reserved byte, key, number of blocks, 84 = Intel; the data follow right after it.
  EXPECT_EQ(bytes.substr(512, 2), "\x01\x50");
  EXPECT_EQ(bytes[515], 84);
  EXPECT_EQ(word(9), 2 + bytes[514]);
  EXPECT_EQ(bytes.size(), 512u * (1 + static_cast<std::size_t>(bytes[514])) + 2 * 3 * 16);
}

TEST_F(C3dWriterTest, ChainsItsParameterRecordsToTheEndOfTheSection) {
  test::write_c3d(path_, 3, 2);
  const std::string bytes = test::read_bytes(path_);
  const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at])); };
  // Walk as the format describes, independently of our reader: the offset counts from its own first byte.
  std::size_t at = 516, parameters = 0, groups = 0;
  while (bytes[at] != 0) {
    const std::size_t offset_at = at + 2 + byte(at);
    const std::size_t offset = byte(offset_at) + 256 * byte(offset_at + 1);
    if (bytes[at + 1] < 0) {
      ++groups;
      EXPECT_EQ(offset, 3u);  // its own two bytes and an empty description
    } else {
      ++parameters;
      std::size_t size = static_cast<std::size_t>(std::abs(bytes[offset_at + 2]));
      const std::size_t dimensions = byte(offset_at + 3);
      for (std::size_t d = 0; d < dimensions; ++d) size *= byte(offset_at + 4 + d);
      EXPECT_EQ(offset, 2 + 2 + dimensions + size + 1) << bytes.substr(at + 2, byte(at));
    }
    at = offset_at + offset;
  }
  EXPECT_EQ(groups, 5u);       // POINT ANALOG FORCE_PLATFORM TRIAL MANUFACTURER
  EXPECT_EQ(parameters, 20u);  // 11 + 3 + 1 + 2 + 3
  EXPECT_LT(at, 512 * (1 + byte(514)));
}

TEST_F(C3dWriterTest, MarksMissingAndFilledPoints) {
  MarkerFrame frame = test::sample_frame(1, 4);
  frame.state = {MarkerState::kMeasured, MarkerState::kFilled, MarkerState::kMissing, MarkerState::kRejected};
  C3dWriter writer(path_, test::sample_set(4), "0.1.0");
  writer.write(frame);
  writer.finish();
  const std::string bytes = test::read_bytes(path_);
  const auto word = [&](std::size_t marker, std::size_t index) {
    return bytes.substr(bytes.size() - 64 + marker * 16 + index * 4, 4);
  };
  EXPECT_EQ(word(0, 3), std::string("\x00\x00\x80\x43", 4));  // 256.0f: camera 1, residual 0
  EXPECT_EQ(word(1, 3), std::string(4, '\0'));                // 0.0f: no camera, residual 0
  for (const std::size_t absent : {2u, 3u}) {
    EXPECT_EQ(word(absent, 3), std::string("\x00\x00\x80\xBF", 4));  // -1.0f
    for (const std::size_t axis : {0u, 1u, 2u}) EXPECT_EQ(word(absent, axis), std::string(4, '\0'));
  }
  C3dReader reader(path_, {});
  const auto back = read_all(reader)[0];
  EXPECT_EQ(back.state[1], MarkerState::kMeasured);  // C3D keeps no more than that there is a position
  EXPECT_EQ(back.state[3], MarkerState::kMissing);
}

TEST_F(C3dWriterTest, Holds256MarkersWithLongLabels) {
  MarkerSet set = test::sample_set(256);
  set.names[0] = std::string(63, 'n');
  C3dWriter writer(path_, set, "0.1.0");
  writer.write(test::sample_frame(0, 256));
  writer.finish();
  EXPECT_NE(test::read_bytes(path_).find("LABELS2"), std::string::npos);
  C3dReader reader(path_, {});
  EXPECT_EQ(reader.info().markers.names, set.names);
  EXPECT_TRUE(reader.info().warnings.empty());
}

/// More frames than 16 bits can count; each statement of the true number alone must be enough.
TEST_F(C3dWriterTest, CountsMoreThan65535Frames) {
  constexpr std::uint64_t kFrames = 70'000;
  test::write_c3d(path_, 1, kFrames);
  const std::string bytes = test::read_bytes(path_);
  for (const auto& hidden : std::vector<std::vector<std::string>>{
           {}, {"LONG_FRAMES"}, {"ACTUAL_END_FIELD"}, {"LONG_FRAMES", "ACTUAL_END_FIELD"}}) {
    std::string changed = bytes;
    for (const std::string& name : hidden) test::hide_parameter(changed, name);
    test::write_bytes(path_, changed);
    EXPECT_EQ(C3dReader(path_, {}).info().frame_count, kFrames) << hidden.size();
  }
  C3dReader reader(path_, {});
  MarkerFrame frame;
  while (reader.next(frame)) {
  }
  EXPECT_EQ(frame.position_mm[0], test::sample_frame(kFrames - 1, 1).position_mm[0]);
  // Cut short between 65535 and the end, the saturated 16-bit counts must not pass for the truth.
  test::write_bytes(path_, bytes.substr(0, bytes.size() - 16 * 1000));
  C3dReader truncated(path_, {});
  EXPECT_EQ(truncated.info().frame_count, kFrames - 1000);
  EXPECT_TRUE(has_warning(truncated, "truncated"));
}

TEST_F(C3dWriterTest, LeavesNothingBehindUnlessFinished) {
  {
    C3dWriter writer(path_, test::sample_set(2), "0.1.0");
    writer.write(test::sample_frame(0, 2));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(C3dWriterTest, RefusesWhatItCannotWrite) {
  EXPECT_THROW(C3dWriter(path_, test::sample_set(0), ""), UserError);
  EXPECT_THROW(C3dWriter(path_, test::sample_set(257), ""), UserError);
  EXPECT_THROW(C3dWriter(path_, test::sample_set(2, 0), ""), UserError);
  EXPECT_THROW(C3dWriter(folder_.path() / "absent" / "take.c3d", test::sample_set(2), ""), UserError);
  C3dWriter writer(path_, test::sample_set(2), "");
  EXPECT_THROW(writer.write(test::sample_frame(0, 3)), std::invalid_argument);
  EXPECT_THROW(writer.finish(), UserError);  // no frame
}

TEST_F(C3dWriterTest, ReportsAFullDisk) {
  // Linux's device that is always full; the .partial name beside the target is a link to it.
  std::filesystem::create_symlink("/dev/full", path_.string() + ".partial");
  C3dWriter writer(path_, test::sample_set(2), "");
  writer.write(test::sample_frame(0, 2));
  EXPECT_THROW(writer.finish(), UserError);
}

}  // namespace
}  // namespace risorius
