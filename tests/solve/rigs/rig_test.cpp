#include "solve/rigs/rig.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "capture/errors.h"
#include "support/test_data.h"
#include "synthetic_face.h"

namespace risorius {
namespace {

using test::synthetic_rig;

std::string error_of(const std::string& json) {
  try {
    parse_rig(json, "actor.json");
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

void expect_equal_bits(const Rig& a, const Rig& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.marker_names, b.marker_names);
  EXPECT_EQ(a.facs_edition, b.facs_edition);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.fit_distance_mm, b.fit_distance_mm);
  EXPECT_TRUE(a.neutral_mm == b.neutral_mm);
  EXPECT_TRUE(a.stabiliser_weight == b.stabiliser_weight);
  ASSERT_EQ(a.au_names(), b.au_names());
  for (std::size_t i = 0; i < a.au_count(); ++i) {
    EXPECT_EQ(a.aus[i].upper_bound, b.aus[i].upper_bound);
    EXPECT_TRUE(a.aus[i].displacement_mm == b.aus[i].displacement_mm);
  }
}

Rig awkward_rig() {
  Rig rig = synthetic_rig(12, 4);
  rig.name = "a \"quoted\" name, \xc3\xa4";
  rig.source = "line\nbreak";
  rig.fit_distance_mm.assign(12, 0.1);
  rig.neutral_mm(0, 7) = 1e-300;
  rig.neutral_mm(1, 7) = std::nextafter(1.0, 2.0);
  rig.neutral_mm(2, 7) = -1.0 / 3;
  rig.aus[1].upper_bound = std::nextafter(1.2, 0.0);
  return rig;
}

TEST(Rig, ComesBackFromItsFileWithEqualBits) {
  const test::TemporaryFolder folder;
  const Rig rig = awkward_rig();
  save_rig(rig, folder.path() / "rig.json");
  expect_equal_bits(load_rig(folder.path() / "rig.json"), rig);
  save_rig(rig, folder.path() / "rig.json");                                            // replaces
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);  // nothing partial is left
}

TEST(Rig, FileErrorsNameTheFile) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(save_rig(awkward_rig(), folder.path() / "absent" / "rig.json"), UserError);
  try {
    load_rig(folder.path() / "absent.json");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("absent.json"), std::string::npos);
  }
}

TEST(Rig, EveryTruncationIsAnErrorAndNeverACrash) {
  const std::string json = rig_to_json(synthetic_rig(7, 1));
  for (std::size_t length = 0; length + 2 < json.size(); ++length) {
    EXPECT_THROW(parse_rig(std::string_view(json).substr(0, length), "cut"), UserError) << length;
  }
}

TEST(Rig, DamagedBytesAreReadOrRefusedNeverACrash) {
  const std::string json = rig_to_json(synthetic_rig(7, 2));
  std::mt19937 random(1);
  int refused = 0;
  for (int draw = 0; draw < 500; ++draw) {
    std::string damaged = json;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    try {
      parse_rig(damaged, "damaged");
    } catch (const UserError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
}

TEST(Rig, ReportsEveryProblemOfAFileTogether) {
  std::string json = rig_to_json(synthetic_rig(7, 2));
  json = replaced(json, "\"source\"", "\"sauce\"");
  json = replaced(json, "\"name\": \"M3\"", "\"name\": 3");
  json = replaced(json, "\"upper_bound\": 1.2", "\"upper_bound\": \"much\"");
  const std::string error = error_of(json);
  for (const char* part : {"actor.json", "unknown key 'sauce'", "markers[3].name: found 3, expected a string",
                           "aus[0].upper_bound: found \"much\", expected a number", "solve/README.md"}) {
    EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
  }
}

TEST(Rig, RefusesOtherFormatsAndVersions) {
  const std::string json = rig_to_json(synthetic_rig(7, 1));
  EXPECT_NE(error_of(replaced(json, "risorius-rig", "other")).find("not a rig file"), std::string::npos);
  EXPECT_NE(error_of(replaced(json, "\"version\": 1", "\"version\": 2")).find("found 2, this program reads version 1"),
            std::string::npos);
  EXPECT_NE(error_of("[]").find("not a rig file"), std::string::npos);
  EXPECT_NE(error_of("{").find("not valid JSON"), std::string::npos);
}

// Found when the fuzz target was written: printing such a value ended the program for want of stack.
TEST(Rig, RefusesAFileThatNestsWithoutEnd) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  const std::string error =
      error_of(R"({"format": "risorius-rig", "version": 1, "name": )" + deep + R"(, "markers": [], "aus": []})");
  EXPECT_NE(error.find("nests too deep"), std::string::npos) << error.substr(0, 200);
  EXPECT_EQ(error_of(R"({"format": "[[[[\"[[[["})").find("nests too deep"), std::string::npos);
}

TEST(Rig, ProblemsNameTheFieldAndItsValue) {
  const Rig good = synthetic_rig(12, 3);
  EXPECT_TRUE(problems_of(good).empty());
  const auto only_problem = [](const Rig& rig) {
    const std::vector<std::string> problems = problems_of(rig);
    EXPECT_EQ(problems.size(), 1u);
    return problems.empty() ? "" : problems.front();
  };
  Rig rig = good;
  rig.aus[0].name = "../../evil";  // AUs name pictures
  EXPECT_NE(only_problem(rig).find("aus[0]: the name has a slash"), std::string::npos);
  rig = good;
  rig.marker_names[2] = "a\nb";
  EXPECT_NE(only_problem(rig).find("markers[2]: the name has a slash, backslash or control"), std::string::npos);
  rig = good;
  rig.marker_names[2] = "M1";
  EXPECT_NE(only_problem(rig).find("markers[2]: the name 'M1' occurs twice"), std::string::npos);
  rig = good;
  rig.aus[1].name.clear();
  EXPECT_NE(only_problem(rig).find("aus[1]"), std::string::npos);
  for (const double bound : {0.0, -1.0, 2.1, std::nan("")}) {
    rig = good;
    rig.aus[1].upper_bound = bound;
    EXPECT_NE(only_problem(rig).find("upper_bound"), std::string::npos);
  }
  rig = good;
  rig.aus[2].displacement_mm.setZero();
  EXPECT_NE(only_problem(rig).find("moves no marker"), std::string::npos);
  rig = good;
  rig.neutral_mm(1, 1) = std::nan("");
  EXPECT_NE(only_problem(rig).find("neutral_mm"), std::string::npos);
  rig = good;
  rig.aus[0].displacement_mm.conservativeResize(3, 11);
  EXPECT_NE(only_problem(rig).find("11 columns for 12 markers"), std::string::npos);
}

TEST(Rig, NeedsThreeStabilisersThatAreNotOnALine) {
  Rig rig = synthetic_rig(12, 3);
  rig.stabiliser_weight.setZero();
  rig.stabiliser_weight.head(2).setOnes();
  EXPECT_EQ(problems_of(rig).size(), 1u);
  rig.stabiliser_weight.head(4).setOnes();
  EXPECT_TRUE(problems_of(rig).empty());
  for (int m = 0; m < 4; ++m) rig.neutral_mm.col(m) = Eigen::Vector3d(10 + m, 2 * m, 70 - m);
  EXPECT_EQ(problems_of(rig).size(), 1u);
}

TEST(Rig, RefusesMoreThanFramesCanCarry) {
  EXPECT_TRUE(problems_of(synthetic_rig(256, 64)).empty());
  EXPECT_FALSE(problems_of(synthetic_rig(257, 2)).empty());
  EXPECT_FALSE(problems_of(synthetic_rig(12, 65)).empty());
  EXPECT_FALSE(problems_of(Rig{}).empty());
}

TEST(Rig, RefusesNumbersThatNoFaceHas) {
  Rig far = synthetic_rig(12, 4);
  far.neutral_mm(1, 3) = 1e300;
  ASSERT_FALSE(problems_of(far).empty());
  EXPECT_NE(problems_of(far)[0].find("markers[3] 'M3': neutral_mm holds 1e+300"), std::string::npos);
  Rig wild = synthetic_rig(12, 4);
  wild.aus[2].displacement_mm(0, 0) = -1e30;
  ASSERT_EQ(problems_of(wild).size(), 1u);
  EXPECT_NE(problems_of(wild)[0].find("displacement_mm holds 1e+30"), std::string::npos);
  Rig heavy = synthetic_rig(12, 4);
  heavy.stabiliser_weight[0] = 1e30;
  heavy.stabiliser_weight[5] = -1;
  ASSERT_EQ(problems_of(heavy).size(), 1u);
  EXPECT_NE(problems_of(heavy)[0].find("markers[0] 'M0' (and 1 more): stabiliser_weight is 1e+30"), std::string::npos)
      << problems_of(heavy)[0];
  Rig distant = synthetic_rig(12, 4);
  distant.fit_distance_mm.assign(12, 1.0);
  distant.fit_distance_mm[7] = -2;
  ASSERT_EQ(problems_of(distant).size(), 1u);
  EXPECT_NE(problems_of(distant)[0].find("markers[7] 'M7': fit_distance_mm is -2"), std::string::npos)
      << problems_of(distant)[0];
}

}  // namespace
}  // namespace risorius
