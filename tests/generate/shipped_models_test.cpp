#include "generate/shipped_models.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

#include "generate/safetensors.h"
#include "generate/transition_features.h"

namespace risorius {
namespace {

const std::vector<std::string> kNames{"AU1", "AU4L", "AU4R", "AU12L", "AU12R", "AU27", "AU45L", "AU45R"};

TEST(ShippedModels, TogetherAreAtMostFourMegabytesAndSayWhereTheyComeFrom) {
  std::uintmax_t bytes = 0;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RISORIUS_SOURCE_DIR "/generate/weights")) {
    if (entry.path().extension() != ".safetensors") continue;
    ++files;
    bytes += entry.file_size();
    const Safetensors file = load_safetensors(entry.path());
    for (const char* key : {"model", "trained_on", "channels", "rate_hz", "configuration"})
      EXPECT_FALSE(file.require_metadata(entry.path().string(), key).empty()) << entry.path();
    for (const auto& [name, tensor] : file.tensors) EXPECT_EQ(tensor.type, TensorType::kBf16) << name;
    EXPECT_EQ(file.metadata.at("trained_on").find("MySlate"), std::string::npos);
  }
  EXPECT_GE(files, 2);
  EXPECT_LE(bytes, 4'000'000u);
}

/// From rest to a smile in a second.
TransitionRequest smile() {
  TransitionRequest request;
  request.rate_hz = 120;
  request.frames = 120;
  request.past = AuMatrix::Zero(20, static_cast<Eigen::Index>(kNames.size()));
  request.target = Eigen::VectorXf::Zero(request.past.cols());
  request.target(3) = request.target(4) = 0.8F;
  return request;
}

TEST(ShippedModels, TheGeneratorSmilesOnceAndCalmly) {
  const auto generator = shipped_expression_generator(kNames);
  AuMatrix course;
  generator->generate(smile(), course);
  EXPECT_EQ(course.row(119), smile().target.transpose());
  const AuMatrix steps = course.bottomRows(119) - course.topRows(119);
  // Minimum jerk's fastest frame makes 1.875 / 120 of the way; a face hurries, but does not leap.
  EXPECT_LT(steps.cwiseAbs().maxCoeff(), 3 * 0.8F * 1.875F / 120);
  EXPECT_GT(course(100, 3), 0.4F);
  // What is not asked for stays small.
  EXPECT_LT(course.col(0).maxCoeff(), 0.15F);
  EXPECT_LT(course.col(5).maxCoeff(), 0.15F);
}

TEST(ShippedModels, AFaceOfFewColumnsGoesStraightThereToo) {
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"AU12L"}, {"AU12L", "AU12R"}, {"AU1", "AU12L", "AU12R", "AU27"}}) {
    const auto generator = shipped_expression_generator(names);
    const auto width = static_cast<Eigen::Index>(names.size());
    TransitionRequest request{.past = AuMatrix::Constant(1, width, 0.5F), .rate_hz = 120};
    request.target = Eigen::VectorXf::Constant(width, 0.9F);
    request.frames = 120;
    AuMatrix course;
    generator->generate(request, course);
    EXPECT_GT(course.minCoeff(), 0.45F) << width << " columns";
    EXPECT_LT(course.maxCoeff(), 1.0F) << width << " columns";
  }
}

TEST(ShippedModels, ALargeExpressionIsExpectedToTakeLongerThanASmallOne) {
  const auto generator = shipped_expression_generator(kNames);
  TransitionRequest small = smile(), large = smile();
  small.target *= 0.25F;
  large.target.head(6).setConstant(1);
  const Eigen::Index frames = generator->expected_frames(smile());
  EXPECT_GT(frames, 41) << "0.34 s: the shortest that it says";
  EXPECT_LT(frames, 240);
  EXPECT_LT(generator->expected_frames(small), generator->expected_frames(large));
}

TEST(ShippedModels, RepetitionsOfOneTransitionVary) {
  const auto generator = shipped_expression_generator(kNames);
  TransitionRequest request = smile();
  AuMatrix expected, varied;
  generator->generate(request, expected);
  float largest = 0;
  for (request.repetition = 1; request.repetition <= 5; ++request.repetition) {
    generator->generate(request, varied);
    largest = std::max(largest, (varied - expected).cwiseAbs().maxCoeff());
    EXPECT_EQ(varied.row(119), expected.row(119));
  }
  EXPECT_GT(largest, 0.01F);
}

TEST(ShippedModels, TheContinuationGoesOnWithAMovement) {
  Continuer continuer(shipped_continuation(kNames, std::vector<double>(kNames.size(), 1.2)));
  Continuation out;
  AuFrame frame;
  frame.status = SolverStatus::kConverged;
  frame.count = static_cast<std::uint32_t>(kNames.size());
  for (std::size_t au = 0; au < kNames.size(); ++au) frame.state[au] = AuState::kObserved;
  for (int i = 0; i <= 30; ++i) {
    // AU12 in the middle of a minimum-jerk smile of 0.5 s, the rest at rest.
    const float share = minimum_jerk(std::clamp(static_cast<float>(i - 15) / 30, 0.0F, 1.0F));
    frame.header.capture_time_ns = i * 16'666'667LL;
    frame.intensity[3] = frame.intensity[4] = 0.8 * static_cast<double>(share);
    ASSERT_TRUE(continuer.process(frame, out));
  }
  EXPECT_GT(out.intensity[0][3], frame.intensity[3] + 0.03) << "50 ms on, a rising AU is higher";
  EXPECT_LT(out.intensity[0][0], 0.05F);
  for (std::size_t step = 1; step < out.step_count; ++step)
    EXPECT_GT(out.standard_deviation[step][3], out.standard_deviation[step - 1][3]) << "less sure of what is farther";
}

}  // namespace
}  // namespace risorius
