#include "replay/takes/c3d_reader.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "replay/takes/c3d_preamble.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::message_of;
using test::read_all;

/// A valid file of 5 markers and 7 frames that a test then damages.
class DamagedC3d : public ::testing::Test {
 protected:
  static constexpr std::size_t kMarkers = 5, kFrames = 7;

  DamagedC3d() {
    test::write_c3d(path_, kMarkers, kFrames);
    bytes_ = test::read_bytes(path_);
  }
  C3dReader reader(const TakeOptions& options = {}) {
    test::write_bytes(path_, bytes_);
    return C3dReader(path_, options);
  }
  std::string error(const TakeOptions& options = {}) {
    return message_of<UserError>([&] { reader(options); });
  }
  void set_parameter(const std::string& name, std::uint16_t value) {
    test::patch_word(bytes_, test::offset_of_parameter(bytes_, name), value);
  }
  std::size_t data_offset() const { return bytes_.size() - kFrames * kMarkers * 16; }
  void set_float(std::size_t frame, std::size_t marker, std::size_t word, float value) {
    std::string encoded;
    append_c3d_float(encoded, value);
    bytes_.replace(data_offset() + (frame * kMarkers + marker) * 16 + word * 4, 4, encoded);
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "take.c3d";
  std::string bytes_;
};

TEST_F(DamagedC3d, IsSoundAtFirst) {
  auto sound = reader();
  EXPECT_TRUE(sound.info().warnings.empty()) << sound.info().warnings.front();
  EXPECT_EQ(read_all(sound).size(), kFrames);
}

TEST_F(DamagedC3d, MayHaveItsParametersElsewhere) {
  const std::uint16_t data_block = static_cast<std::uint16_t>(data_offset() / 512 + 1);
  bytes_[0] = 3;
  test::patch_word(bytes_, 16, data_block + 1);
  set_parameter("DATA_START", data_block + 1);
  bytes_.insert(512, std::string(512, 'x'));
  auto moved = reader();
  EXPECT_TRUE(moved.info().warnings.empty());
  const auto frames = read_all(moved);
  ASSERT_EQ(frames.size(), kFrames);
  EXPECT_EQ(frames[3].position_mm[2], test::sample_frame(3, kMarkers).position_mm[2]);
}

TEST_F(DamagedC3d, ConvertsItsUnitInDoubleAndRoundsOnce) {
  const std::size_t units = test::offset_of_parameter(bytes_, "UNITS");
  const float stored = test::sample_frame(1, kMarkers).position_mm[0].x;
  for (const auto& [unit, mm_per_unit] : {std::pair{"mm", 1.0}, {"cm", 10.0}, {"m ", 1000.0}, {"MM", 1.0}}) {
    bytes_.replace(units, 2, unit);
    auto take = reader();
    EXPECT_EQ(read_all(take)[1].position_mm[0].x, static_cast<float>(static_cast<double>(stored) * mm_per_unit))
        << unit;
  }
}

TEST_F(DamagedC3d, AssumesMillimetresWhereTheUnitIsEmpty) {
  bytes_.replace(test::offset_of_parameter(bytes_, "UNITS"), 2, "  ");
  auto take = reader();
  EXPECT_TRUE(has_warning(take, "POINT:UNITS"));
  EXPECT_EQ(take.info().markers.mm_per_unit, 1);
}

TEST_F(DamagedC3d, RefusesAnUnknownUnitUnlessTheUserGivesOne) {
  bytes_.replace(test::offset_of_parameter(bytes_, "UNITS"), 2, "ft");
  EXPECT_NE(error().find("POINT:UNITS is 'ft'"), std::string::npos);
  EXPECT_EQ(reader({.mm_per_unit = 304.8}).info().markers.mm_per_unit, 304.8);
}

TEST_F(DamagedC3d, MakesLabelsUnique) {
  const std::size_t labels = test::offset_of_parameter(bytes_, "LABELS");
  bytes_.replace(labels, 8, "marker 2");  // now twice
  bytes_.replace(labels + 16, 8, "        ");
  auto take = reader();
  EXPECT_EQ(take.info().markers.names,
            (std::vector<std::string>{"marker 2", "marker 2_2", "point_3", "marker 4", "marker 5"}));
  EXPECT_TRUE(has_warning(take, "marker 2_2"));
  EXPECT_TRUE(has_warning(take, "1 of 5 points have no label"));
}

TEST_F(DamagedC3d, NamesPointsByNumberWhereAllLabelsAreMissing) {
  test::hide_parameter(bytes_, "LABELS");
  EXPECT_EQ(reader().info().markers.names.back(), "point_5");
}

TEST_F(DamagedC3d, WarnsOfMoreLabelsThanPoints) {
  set_parameter("USED", 4);
  test::patch_word(bytes_, 2, 4);
  EXPECT_TRUE(has_warning(reader(), "5 labels for 4 points"));
}

TEST_F(DamagedC3d, TakesTheFourthWordByItsValue) {
  // The value is a 16-bit integer: negative in 16 bits is invalid, whatever else it says.
  const std::vector<std::pair<float, bool>> cases = {{0.0f, true},       {256.0f, true}, {15888.0f, true},
                                                     {32767.0f, true},   {-1.0f, false}, {65535.0f, false},
                                                     {-32768.0f, false}, {1e9f, false},  {std::nanf(""), false}};
  for (const auto& [word, is_valid] : cases) {
    set_float(2, 1, 3, word);
    auto take = reader();
    EXPECT_EQ(read_all(take)[2].state[1] == MarkerState::kMeasured, is_valid) << word;
  }
}

TEST_F(DamagedC3d, TakesOriginAndNanForMissing) {
  for (const std::size_t word : {0u, 1u, 2u}) set_float(0, 0, word, 0.0f);
  set_float(0, 1, 2, std::nanf(""));
  set_float(0, 2, 0, std::numeric_limits<float>::infinity());
  auto take = reader();
  const auto frame = read_all(take)[0];
  for (const std::size_t marker : {0u, 1u, 2u}) {
    EXPECT_EQ(frame.state[marker], MarkerState::kMissing);
    EXPECT_EQ(frame.position_mm[marker], Position());
  }
  EXPECT_EQ(frame.state[3], MarkerState::kMeasured);
}

TEST_F(DamagedC3d, RefusesAFileWithoutPoints) {
  set_parameter("USED", 0);
  EXPECT_NE(error().find("POINT:USED is 0"), std::string::npos) << error();
}

TEST_F(DamagedC3d, RefusesMoreMarkersThanAFrameHoldsWithTheirNumber) {
  set_parameter("USED", 300);
  EXPECT_NE(error().find("POINT:USED is 300"), std::string::npos) << error();
}

TEST_F(DamagedC3d, NeedsARate) {
  bytes_.replace(20, 4, std::string(4, '\0'));
  bytes_.replace(test::offset_of_parameter(bytes_, "RATE"), 4, std::string(4, '\0'));
  EXPECT_NE(error().find("POINT:RATE"), std::string::npos);
  EXPECT_EQ(reader({.rate_hz = 50}).info().markers.rate_hz, 50);
  EXPECT_FALSE(error({.rate_hz = -1}).empty());
  EXPECT_FALSE(error({.rate_hz = 0}).empty());
}

TEST_F(DamagedC3d, KeepsWholeFramesOfATruncatedFile) {
  bytes_.resize(bytes_.size() - 1);
  auto take = reader();
  EXPECT_EQ(take.info().frame_count, kFrames - 1);
  EXPECT_TRUE(has_warning(take, "truncated: 7 frames declared, 6 whole ones found"));
  EXPECT_EQ(read_all(take).size(), kFrames - 1);
}

TEST_F(DamagedC3d, TurnsTheFilesAxes) {
  // A file whose y grows to the front and whose z grows upwards: (x, y, z) -> (x, z, y) mirrored in x to stay
  // right-handed.
  auto take = reader({.axes = Axes::parse("RFU")});
  const Position stored = test::sample_frame(0, kMarkers).position_mm[0];
  EXPECT_EQ(read_all(take)[0].position_mm[0], (Position{-stored.x, stored.z, stored.y}));
}

TEST_F(DamagedC3d, SaysThatYIsProbablyNotUp) {
  bytes_.replace(test::offset_of_parameter(bytes_, "Y_SCREEN"), 2, "+Z");
  EXPECT_TRUE(has_warning(reader(), "POINT:Y_SCREEN is '+Z'"));
  EXPECT_TRUE(reader({.axes = Axes::parse("RFU")}).info().warnings.empty());
}

TEST_F(DamagedC3d, SkipsAnalogValues) {
  // Three analog floats after each frame's points.
  test::patch_word(bytes_, 4, 3);
  const std::size_t begin = 512 * (static_cast<unsigned char>(bytes_[16]) - 1u);
  std::string with_analog = bytes_.substr(0, begin);
  for (std::size_t frame = 0; frame < kFrames; ++frame)
    with_analog += bytes_.substr(begin + frame * kMarkers * 16, kMarkers * 16) + std::string(12, '\x41');
  bytes_ = with_analog;
  auto take = reader();
  EXPECT_EQ(read_all(take)[6].position_mm[4], test::sample_frame(6, kMarkers).position_mm[4]);
}

TEST_F(DamagedC3d, NeverCrashesWhereverItEnds) {
  const std::string whole = bytes_;
  std::size_t readable = 0;
  for (std::size_t size = 0; size < whole.size(); size += size < data_offset() ? 37 : 11) {
    bytes_ = whole.substr(0, size);
    const std::string problem = message_of<UserError>([&] {
      auto take = reader();
      EXPECT_EQ(read_all(take).size(), *take.info().frame_count);
      ++readable;
    });
    if (size < 512) {
      EXPECT_NE(problem.find("take.c3d"), std::string::npos) << size;
    }
  }
  EXPECT_GE(readable, 40u);  // 560 bytes of frames in steps of 11, less the first frame
}

TEST_F(DamagedC3d, NeverCrashesWhateverItsFirstBytesSay) {
  const std::string whole = bytes_;
  std::mt19937 random(20260);
  for (int trial = 0; trial < 3000; ++trial) {
    bytes_ = whole;
    for (int flip = 0; flip <= trial % 4; ++flip)
      bytes_[random() % std::min<std::size_t>(2048, bytes_.size())] = static_cast<char>(random());
    message_of<UserError>([&] {
      auto take = reader();
      EXPECT_EQ(read_all(take).size(), *take.info().frame_count);
    });
  }
}

TEST_F(DamagedC3d, ReadsTheSameAfterRewind) {
  auto take = reader();
  const auto first = read_all(take);
  take.rewind();
  const auto again = read_all(take);
  ASSERT_EQ(again.size(), first.size());
  EXPECT_EQ(again[4].position_mm, first[4].position_mm);
  EXPECT_EQ(again[4].header.sequence, 4u);
}

}  // namespace
}  // namespace risorius
