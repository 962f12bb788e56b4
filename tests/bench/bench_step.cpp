// The step of seed 003's network (1,894,927 weights) with fp32 and bf16 weights, and what the shipped models take.
// Beside libtorch: bench_step_libtorch, built with the trainer.
#include "bench/bench_report.h"
#include "bench/step_case.h"
#include "generate/shipped_models.h"
#include "made_seed_weights.h"
#include "replay/corpus/expression_corpus.h"

namespace risorius::bench {
namespace {

/// A step that feeds its frame back, as generating does.
template <typename Weight>
std::function<void()> step_of(const Safetensors& weights) {
  const std::string place = "formula";
  auto network = std::make_shared<SeedNetwork<Weight>>(WeightsReader{weights, place}, test::kSeedAus);
  network->start(test::made_seed_past(), test::made_seed_target());
  auto frame = std::make_shared<std::vector<float>>(static_cast<std::size_t>(test::kSeedAus));
  return [network, frame] { network->next(*frame); };
}

std::function<void()> transition_of_a_second() {
  const std::vector<std::string> names = corpus_aus();
  std::shared_ptr<TransitionModel> model = shipped_expression_generator(names);
  auto request = std::make_shared<TransitionRequest>();
  request->past = AuMatrix::Zero(20, static_cast<Eigen::Index>(names.size()));
  request->target = Eigen::VectorXf::Constant(request->past.cols(), 0.3F);
  request->frames = 120;
  request->rate_hz = 120;
  auto result = std::make_shared<AuMatrix>();
  return [model, request, result] { model->generate(*request, *result); };
}

std::function<void()> continuation() {
  const std::vector<std::string> names = corpus_aus();
  auto continuer = std::make_shared<Continuer>(shipped_continuation(names, std::vector<double>(names.size(), 1.2)));
  auto frame = std::make_shared<AuFrame>();
  frame->status = SolverStatus::kConverged;
  frame->count = static_cast<std::uint32_t>(names.size());
  frame->state.fill(AuState::kObserved);
  auto out = std::make_shared<Continuation>();
  return [continuer, frame, out] {
    frame->header.capture_time_ns += 16'666'667;
    frame->intensity[3] = 0.5;
    continuer->process(*frame, *out);
  };
}

int run() {
  BenchReport report("step");
  const Safetensors weights = test::made_seed_weights();
  const auto times = step_times_us({{"fp32", step_of<float>(weights)}, {"bf16", step_of<Bf16>(weights)}});
  report.add("seed network, fp32 weights", times.at("fp32"));
  report.add("seed network, bf16 weights", times.at("bf16"));
  report.add("bf16 / fp32", times.at("bf16") / times.at("fp32"));
  const auto shipped = step_times_us({{"transition", transition_of_a_second()}, {"continuation", continuation()}});
  report.add("expression generator, a transition of 120 frames, 41 AUs", shipped.at("transition") * 1e-3);
  report.add("continuation, 41 AUs", shipped.at("continuation"));
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main() { return risorius::bench::run(); }
