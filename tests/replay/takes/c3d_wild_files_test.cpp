// Files of other systems: what C3D is in the wild.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius {
namespace {

using test::has_warning;
using test::message_of;
using test::read_all;

struct Gaps {
  std::size_t missing = 0, gaps = 0;
};

Gaps count_gaps(const std::vector<MarkerFrame>& frames) {
  Gaps result;
  for (std::size_t i = 0; i < frames[0].count; ++i) {
    bool was_missing = false;
    for (const MarkerFrame& frame : frames) {
      const bool missing = frame.state[i] == MarkerState::kMissing;
      result.missing += missing;
      result.gaps += missing && !was_missing;
      was_missing = missing;
    }
  }
  return result;
}

TEST(C3dWildFiles, ReadsOneTakeFromSixEncodings) {
  RISORIUS_NEEDS_DATA(folder, "c3d");
  const auto read = [&](const char* name) { return read_all(*open_take(folder / name)); };
  const auto intel_float = read("Eb015pr.c3d"), dec_float = read("Eb015vr.c3d"), mips_float = read("Eb015sr.c3d");
  const auto intel_integer = read("Eb015pi.c3d"), dec_integer = read("Eb015vi.c3d"), mips_integer = read("Eb015si.c3d");
  ASSERT_EQ(intel_float.size(), 450u);  // header words 4 and 5: 1 to 450
  for (std::size_t f = 0; f < intel_float.size(); ++f) {
    EXPECT_EQ(intel_float[f].position_mm, dec_float[f].position_mm) << f;
    EXPECT_EQ(intel_float[f].position_mm, mips_float[f].position_mm) << f;
    EXPECT_EQ(intel_integer[f].position_mm, dec_integer[f].position_mm) << f;
    EXPECT_EQ(intel_integer[f].position_mm, mips_integer[f].position_mm) << f;
    EXPECT_EQ(intel_float[f].state, intel_integer[f].state) << f;
    for (std::size_t i = 0; i < intel_float[f].count; ++i) {
      EXPECT_NEAR(intel_float[f].position_mm[i].x, intel_integer[f].position_mm[i].x, 5e-4);
      EXPECT_NEAR(intel_float[f].position_mm[i].y, intel_integer[f].position_mm[i].y, 5e-4);
      EXPECT_NEAR(intel_float[f].position_mm[i].z, intel_integer[f].position_mm[i].z, 5e-4);
    }
  }
  // The first point of the float file, decoded by hand: counts 2983 2722 449 times 1/12 mm.
  EXPECT_EQ(intel_float[0].position_mm[0], (Position{248.58334350585938f, 226.83334350585938f, 37.41666793823242f}));
}

TEST(C3dWildFiles, FindsTheGapsOfRealFiles) {
  RISORIUS_NEEDS_DATA(folder, "c3d");
  // Counted with a separate script: runs of residual < 0. In the second file one of the 40 markers is never seen: its
  // 701 frames are one run, the other 226 are true gaps.
  const auto vicon = count_gaps(read_all(*open_take(folder / "Vicon.c3d")));
  EXPECT_EQ(vicon.missing, 305u);
  EXPECT_EQ(vicon.gaps, 34u);
  const auto phasespace = count_gaps(read_all(*open_take(folder / "phasespace_sample.c3d")));
  EXPECT_EQ(phasespace.missing, 1281u);
  EXPECT_EQ(phasespace.gaps, 227u);
}

TEST(C3dWildFiles, ReadsAFileWithoutAnyParameters) {
  RISORIUS_NEEDS_DATA(path, "c3d/phasespace_sample.c3d");
  const auto take = open_take(path);
  EXPECT_EQ(take->info().markers.names.front(), "point_1");
  EXPECT_EQ(take->info().markers.rate_hz, 30);  // header words 11-12: 41F00000 = 30.0f
  EXPECT_TRUE(has_warning(*take, "mm assumed"));
  EXPECT_TRUE(has_warning(*take, "40 of 40 points have no label"));
}

TEST(C3dWildFiles, GetsThePointsOfDamagedFiles) {
  RISORIUS_NEEDS_DATA(folder, "c3d");
  // Points and frames as the files' header words 2, 4 and 5 give them; measured = points * frames less those that are
  // (0,0,0) in the raw bytes, counted with a separate script.
  struct File {
    const char* name;
    std::size_t points, frames, measured;
    const char* warning;
  };
  for (const File& file : {File{"bad_parameter_section.c3d", 45, 332, 14940 - 6044, "lies outside the section"},
                           File{"badParameterOffset.c3d", 41, 111, 4551 - 222, "UNITS declares 128 bytes and has 4"},
                           File{"parameterOverflow.c3d", 142, 101, 14342 - 11996, "longer than the 46 blocks"}}) {
    const auto take = open_take(folder / file.name);
    EXPECT_EQ(take->info().markers.names.size(), file.points) << file.name;
    EXPECT_TRUE(has_warning(*take, file.warning)) << file.name;
    const auto frames = read_all(*take);
    EXPECT_EQ(frames.size(), file.frames) << file.name;
    std::size_t measured = 0;
    for (const MarkerFrame& frame : frames)
      for (std::size_t i = 0; i < frame.count; ++i) {
        measured += frame.state[i] == MarkerState::kMeasured;
        EXPECT_LT(std::abs(frame.position_mm[i].x), 1e4f) << file.name << ": no laboratory is 10 m wide";
      }
    EXPECT_EQ(measured, file.measured) << file.name;
  }
}

TEST(C3dWildFiles, RefusesAnEmptyFile) {
  RISORIUS_NEEDS_DATA(path, "c3d/Empty.c3d");
  const std::string message = message_of<UserError>([&] { open_take(path); });
  EXPECT_NE(message.find("the file has 0 bytes"), std::string::npos) << message;
}

TEST(C3dWildFiles, AgreesWithTheCsvOfTheSameTake) {
  RISORIUS_NEEDS_DATA(folder, "animface");
  for (const char* name : {"jaw", "eyebrows"}) {
    const auto c3d = open_take(folder / (std::string(name) + ".c3d"));
    const auto csv = open_take(folder / (std::string(name) + ".csv"), {.mm_per_unit = 10});
    ASSERT_EQ(c3d->info().markers.names, csv->info().markers.names);
    EXPECT_EQ(csv->info().markers.rate_hz, 60);
    EXPECT_TRUE(csv->info().warnings.empty());
    MarkerFrame from_c3d, from_csv;
    while (c3d->next(from_c3d)) {
      ASSERT_TRUE(csv->next(from_csv));
      EXPECT_EQ(from_c3d.header.capture_time_ns, from_csv.header.capture_time_ns);
      for (std::size_t i = 0; i < from_c3d.count; ++i) {
        // The CSV has six decimals of a centimetre (5e-6 mm); a float near 1000 mm has steps of 6e-5 mm.
        EXPECT_NEAR(from_c3d.position_mm[i].x, from_csv.position_mm[i].x, 7e-5);
        EXPECT_NEAR(from_c3d.position_mm[i].y, from_csv.position_mm[i].y, 7e-5);
        EXPECT_NEAR(from_c3d.position_mm[i].z, from_csv.position_mm[i].z, 7e-5);
      }
    }
    EXPECT_FALSE(csv->next(from_csv));
  }
}

}  // namespace
}  // namespace risorius
