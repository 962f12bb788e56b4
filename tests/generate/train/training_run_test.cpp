// Training in small: what a long one relies on, that it can be interrupted and repeated, to the byte.
#include "generate/train/training_run.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <stdexcept>

#include "capture/errors.h"
#include "generate/continuation_features.h"
#include "generate/train/continuation_network.h"
#include "generate/train/export_weights.h"
#include "generate/train/expression_network.h"
#include "replay/corpus/expression_corpus.h"

namespace risorius {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class TrainingRun : public testing::Test {
 protected:
  TrainingRun() {
    torch::set_num_threads(1);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~TrainingRun() override { fs::remove_all(folder_); }

  TrainingOptions options(const std::string& run, std::uint64_t seed = 1) const {
    TrainingOptions result;
    result.steps = 7;
    result.seed = seed;
    result.measure_every = 2;
    result.folder = folder_ / run;
    result.name = "tiny";
    return result;
  }

  fs::path folder_ = fs::path(testing::TempDir()) / (std::string("risorius_training_") +
                                                     testing::UnitTest::GetInstance()->current_test_info()->name());
};

struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A continuation network that learns noise drawn in every step. Throws Interrupted before step `until`.
std::string trained(const TrainingOptions& options, std::int64_t until = 1000) {
  torch::manual_seed(options.seed);
  ContinuationNetwork network(ContinuationArchitecture::kMlp, 8);
  train(
      *network, options,
      [&](std::int64_t step) {
        if (step == until) throw Interrupted("interrupted");
        return (network->forward(torch::randn({16, kContinuationWidth})) - torch::randn({16, 10})).square().mean();
      },
      [&] {
        return Measurements{{"sum", network->output->weight.sum().item<double>()}};
      });
  export_weights(*network, {{"model", "tiny"}}, options.folder / "tiny.safetensors");
  return bytes_of(options.folder / "tiny.safetensors");
}

TEST_F(TrainingRun, InterruptedAndResumedGivesTheSameBytesAsOneThatWasNot) {
  const std::string whole = trained(options("whole"));
  ASSERT_GT(whole.size(), 1000U);
  // Between two checkpoints, on one, and before the first.
  for (const std::int64_t until : {5, 4, 1}) {
    const TrainingOptions in_parts = options("parts" + std::to_string(until));
    EXPECT_THROW(trained(in_parts, until), Interrupted);
    EXPECT_FALSE(fs::exists(in_parts.folder / "tiny.safetensors"));
    EXPECT_EQ(trained(in_parts), whole) << until;
    EXPECT_EQ(bytes_of(in_parts.folder / "tiny.csv"), bytes_of(options("whole").folder / "tiny.csv")) << until;
  }
}

TEST_F(TrainingRun, ThatIsFinishedDrawsNothingMore) {
  const std::string first = trained(options("done"));
  EXPECT_EQ(trained(options("done"), 0), first) << "no step is made again";
}

TEST_F(TrainingRun, RefusesTheCheckpointOfAnother) {
  TrainingOptions other = options("other");
  trained(other);
  other.what = "other data";
  EXPECT_THROW(trained(other), UserError);
  EXPECT_THROW(trained(options("other", 2)), UserError);
}

/// The Expression-Generator's own network and data, of one performance.
std::string trained_generator(const TrainingOptions& options, const TransitionCorpus& corpus) {
  const std::vector<const Transition*> chosen = part_of(corpus, CorpusPart::kTrain);
  const TransitionTensors data = transition_tensors(corpus.names, chosen, corpus.rate_hz, 5);
  torch::manual_seed(options.seed);
  ExpressionNetwork network(ExpressionNetworkOptions{2, 4, 4});
  const torch::Tensor basis = residual_basis();
  train(
      *network, options,
      [&](std::int64_t) {
        const torch::Tensor noise = torch::randn({data.transitions, kTransitionNoise});
        torch::Tensor loss = torch::zeros({});
        for (ExpressionMember& member : network->members) {
          loss = loss + (courses_of(data, member->forward(data, noise), basis) - data.course).square().mean();
        }
        return loss;
      },
      [] {
        return Measurements{{"none", 0.0}};
      });
  export_weights(*network, {{"model", "expression_generator"}}, options.folder / "tiny.safetensors");
  return bytes_of(options.folder / "tiny.safetensors");
}

TEST_F(TrainingRun, TheSameSeedGivesTheSameGeneratorToTheByteAndAnotherSeedAnother) {
  const auto corpus = [](std::uint64_t seed) { return perform_expressions({"AU1", "AU12L", "AU12R"}, {seed, 1}); };
  const std::string first = trained_generator(options("first"), corpus(1));
  ASSERT_GT(first.size(), 1000U);
  EXPECT_EQ(trained_generator(options("again"), corpus(1)), first);
  EXPECT_NE(trained_generator(options("data"), corpus(2)), first);
  EXPECT_NE(trained_generator(options("seed", 2), corpus(1)), first);
}

}  // namespace
}  // namespace risorius
