#include "generate/seed_generator.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "capture/errors.h"
#include "generate/transition_features.h"
#include "made_seed_weights.h"
#include "support/allocation_counter.h"

namespace risorius {
namespace {

using namespace test;

template <typename Weight>
AuMatrix rollout() {
  const Safetensors weights = made_seed_weights();
  const std::string place = "test";
  SeedNetwork<Weight> network({weights, place}, kSeedAus);
  network.start(made_seed_past(), made_seed_target());
  AuMatrix frames(kRolloutFrames, kSeedAus);
  for (Eigen::Index f = 0; f < kRolloutFrames; ++f)
    network.next({frames.row(f).data(), static_cast<std::size_t>(kSeedAus)});
  return frames;
}

TEST(SeedNetwork, HasTheThesisNumberOfWeights) {
  std::size_t count = 0;
  for (const auto& [name, tensor] : made_seed_weights().tensors) count += tensor.size();
  EXPECT_EQ(count, 1'894'927u);
}

// golden/seed_rollout.safetensors was written by bench_step_libtorch --golden: libtorch's rollout of the same weights
// in double (as the sum of two floats) and in float.
TEST(SeedNetwork, ErrsAtMostTwiceAsMuchAsLibtorchOverAHundredFrames) {
  const Safetensors golden = load_safetensors(RISORIUS_SOURCE_DIR "/tests/generate/golden/seed_rollout.safetensors");
  const std::vector<std::int64_t> shape{kRolloutFrames, kSeedAus};
  const auto high = golden.require("golden", "reference", shape).values(),
             low = golden.require("golden", "reference_rest", shape).values(),
             libtorch = golden.require("golden", "libtorch", shape).values();
  const AuMatrix ours = rollout<float>();
  double our_worst = 0, their_worst = 0, our_sum = 0, their_sum = 0, spread = 0;
  for (std::size_t i = 0; i < high.size(); ++i) {
    const double truth = static_cast<double>(high[i]) + static_cast<double>(low[i]);
    const double our_error = static_cast<double>(ours.data()[i]) - truth,
                 their_error = static_cast<double>(libtorch[i]) - truth;
    our_worst = std::max(our_worst, std::abs(our_error));
    their_worst = std::max(their_worst, std::abs(their_error));
    our_sum += our_error * our_error;
    their_sum += their_error * their_error;
    spread = std::max(spread, std::abs(truth - static_cast<double>(high[i % kSeedAus])));
  }
  RecordProperty("ours", std::to_string(our_worst));
  RecordProperty("libtorch", std::to_string(their_worst));
  EXPECT_GT(spread, 0.01) << "the rollout moves";
  EXPECT_LE(our_worst, 2 * their_worst);
  EXPECT_LE(our_sum, 4 * their_sum);
}

TEST(SeedNetwork, Bf16GivesTheSameBitsForWeightsThatAreBf16) { EXPECT_EQ(rollout<float>(), rollout<Bf16>()); }

TEST(SeedNetwork, AllocatesNothingInAStep) {
  const Safetensors weights = made_seed_weights();
  const std::string place = "test";
  SeedNetwork<Bf16> network({weights, place}, kSeedAus);
  const AuMatrix past = made_seed_past();
  const Eigen::VectorXf target = made_seed_target();
  std::vector<float> frame(kSeedAus);
  const auto before = allocations_of_this_thread();
  network.start(past, target);
  for (int i = 0; i < 5; ++i) network.next(frame);
  EXPECT_EQ(allocations_of_this_thread(), before);
}

TEST(SeedNetwork, TakesAnInitialiserAndADeeperDecoder) {
  Safetensors weights = made_seed_weights();
  add_dense(weights, "initialiser_1", kSeedInitialiserUnits, 2 * kSeedAus, 0.3F);
  add_dense(weights, "initialiser_2", 2 * (kSeedEncoderUnits + kSeedGeneratorUnits), kSeedInitialiserUnits, 0.3F);
  add_dense(weights, "decode_1", kSeedDecodeUnits, kSeedGeneratorUnits, 0.1F);
  add_dense(weights, "decode_2", kSeedDecodeUnits, kSeedDecodeUnits, 0.1F);
  add_dense(weights, "output", kSeedAus, kSeedDecodeUnits, 0.1F);
  const std::string place = "test";
  SeedNetwork<float> network({weights, place}, kSeedAus);
  network.start(made_seed_past(), made_seed_target());
  std::vector<float> frame(kSeedAus), before = frame;
  network.next(frame);
  EXPECT_NE(frame, before);
  EXPECT_NE(frame[0], rollout<float>()(0, 0));
}

const std::vector<std::string> kNames{"AU2R", "AU12L", "AU1L"};

TransitionRequest request_of(Eigen::Index frames, double rate_hz) {
  TransitionRequest request;
  request.rate_hz = rate_hz;
  request.frames = frames;
  request.past = AuMatrix::Constant(3, 3, 0.4F);
  request.target.resize(3);
  request.target << 0.1F, 0.9F, 0.6F;
  return request;
}

TEST(SeedGenerator, SaysWhichModelTheWeightsAreOfBeforeAllElse) {
  Safetensors weights;
  weights.metadata = {{"model", "continuation"}, {"channels", ""}, {"rate_hz", "any"}};
  try {
    SeedGenerator(weights, "file.safetensors", {"AU1"});
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("file.safetensors: is a model 'continuation'"), std::string::npos)
        << error.what();
  }
}

TEST(SeedGenerator, MapsByNameAndMasksWhatItDoesNotKnow) {
  SeedGenerator generator(made_seed_weights(), "test", kNames);
  EXPECT_EQ(generator.masked(), std::vector<std::string>{"AU12L"});
  EXPECT_EQ(generator.name(), "seed");
  AuMatrix result;
  generator.generate(request_of(60, 120), result);
  ASSERT_EQ(result.rows(), 60);
  for (Eigen::Index f = 0; f < 60; ++f)
    EXPECT_NEAR(result(f, 1), 0.4F + 0.5F * minimum_jerk(static_cast<float>(f + 1) / 60), 1e-6F);
  EXPECT_GE(result.minCoeff(), 0);
  EXPECT_LE(result.maxCoeff(), 1.2F);
  // Columns follow their names.
  SeedGenerator swapped(made_seed_weights(), "test", {"AU1L", "AU12L", "AU2R"});
  TransitionRequest request = request_of(60, 120);
  request.target << 0.6F, 0.9F, 0.1F;
  AuMatrix other;
  swapped.generate(request, other);
  EXPECT_EQ(result.col(0), other.col(2));
  EXPECT_EQ(result.col(2), other.col(0));
}

TEST(SeedGenerator, ResamplesToTheRateOfTheRequest) {
  SeedGenerator generator(made_seed_weights(), "test", kNames);
  AuMatrix at_120, at_60;
  generator.generate(request_of(80, 120), at_120);
  generator.generate(request_of(40, 60), at_60);
  for (Eigen::Index f = 0; f < 40; ++f) EXPECT_NEAR(at_60(f, 0), at_120(2 * f + 1, 0), 1e-6F);
}

TEST(SeedGenerator, ReinterpolatesItsFirstFramesAsACure) {
  SeedGenerator plain(made_seed_weights(), "test", kNames),
      cured(made_seed_weights(), "test", kNames, SeedCure::kReinterpolated);
  EXPECT_EQ(cured.name(), "seed_reinterpolated");
  AuMatrix a, b;
  plain.generate(request_of(40, 120), a);
  cured.generate(request_of(40, 120), b);
  EXPECT_EQ(a.bottomRows(35), b.bottomRows(35));
  for (Eigen::Index f = 0; f < 5; ++f)
    EXPECT_NEAR(b(f, 0), 0.4F + static_cast<float>(f + 1) / 6 * (a(5, 0) - 0.4F), 1e-6F);
}

TEST(SeedGenerator, RefusesWhatDoesNotFit) {
  Safetensors weights = made_seed_weights();
  weights.metadata["rate_hz"] = "fast";
  EXPECT_THROW(SeedGenerator(weights, "test", kNames), UserError);
  weights = made_seed_weights();
  weights.metadata["channels"] = "AU1L";
  EXPECT_THROW(SeedGenerator(weights, "test", kNames), UserError);
  SeedGenerator generator(made_seed_weights(), "test", kNames);
  AuMatrix result;
  TransitionRequest request = request_of(40, 120);
  request.target(1) = NAN;
  EXPECT_THROW(generator.generate(request, result), std::invalid_argument);
  EXPECT_THROW(generator.generate(request_of(0, 120), result), std::invalid_argument);
}

}  // namespace
}  // namespace risorius
