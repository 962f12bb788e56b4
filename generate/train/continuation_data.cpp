#include "generate/train/continuation_data.h"

#include <algorithm>
#include <cmath>

#include "generate/continuation_features.h"
#include "replay/performer/random.h"

namespace risorius {
namespace {

constexpr double kBlockS = 10, kReachS = 0.5;
constexpr float kStillScale = 0.0105F;  ///< of an AU that does not move; the least is 0.01
constexpr int kStillRows = 10;

bool is_held_out(double time_s) {
  const auto block = static_cast<long>(time_s / kBlockS) % 5;
  return block == 2 || block == 4;
}

torch::Tensor tensor_of(const std::vector<float>& values, std::vector<std::int64_t> shape) {
  return torch::tensor(values, torch::kFloat32).reshape(shape);
}

}  // namespace

void ContinuationDataMaker::add(const AuRecording& recording, const ContinuationPass& pass, MomentPart part) {
  const AuSeries& series = recording.series;
  ContinuationFeatureMaker maker(series.names);
  ContinuationFeatures features = maker.allocate();
  Random random(pass.seed, 17);
  const double rate_hz = recording.rate_hz * pass.speed;
  std::vector<float> seen(series.names.size(), 0);
  int still = 0;
  const auto time_s = [&](std::size_t f) { return static_cast<double>(series.frames[f]) / rate_hz; };
  const auto value = [&](std::size_t f, std::size_t k) {
    const double x = series.intensities[f][k];
    return std::isnan(x) ? 0 : std::clamp(pass.strength * x, 0.0, 1.2);
  };
  for (std::size_t f = 0; f < series.frames.size(); f += static_cast<std::size_t>(pass.skip)) {
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const double noise = pass.noise > 0 ? pass.noise * random.gaussian() : 0;
      seen[k] = static_cast<float>(std::clamp(value(f, k) + noise, 0.0, 1.2));
    }
    maker.observe(std::llround(time_s(f) * 1e9), seen);
    if (time_s(f) < 0.1 || time_s(f) + kReachS > time_s(series.frames.size() - 1)) continue;
    const double recorded_s = time_s(f) * pass.speed;
    const bool is_test = is_held_out(recorded_s);
    const bool crosses = is_held_out(recorded_s + kReachS * pass.speed) != is_test;
    if (part != MomentPart::kAll && (is_test != (part == MomentPart::kHeldOut) || crosses)) continue;
    maker.make(features);
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const auto au = static_cast<Eigen::Index>(k);
      if (features.scale(au) < kStillScale && ++still % kStillRows != 0) continue;
      inputs_.insert(inputs_.end(), features.inputs.row(au).begin(), features.inputs.row(au).end());
      scale_.push_back(features.scale(au));
      value_.push_back(features.value(au));
      std::size_t next = f;
      for (const double horizon_ms : kContinuationHorizonsMs) {
        const double target_s = time_s(f) + horizon_ms * 1e-3;
        while (time_s(next + 1) < target_s) ++next;
        const double share = (target_s - time_s(next)) / (time_s(next + 1) - time_s(next));
        const double truth = value(next, k) + share * (value(next + 1, k) - value(next, k));
        change_.push_back(static_cast<float>(truth) - features.value(au));
        damped_.push_back(features.velocity_per_s(au) * static_cast<float>(damped_way(horizon_ms * 1e-3)));
      }
    }
  }
}

ContinuationTensors ContinuationDataMaker::tensors() const {
  const auto rows = static_cast<std::int64_t>(scale_.size());
  constexpr auto kHorizons = static_cast<std::int64_t>(kContinuationHorizonsMs.size());
  return {tensor_of(inputs_, {rows, kContinuationWidth}), tensor_of(damped_, {rows, kHorizons}),
          tensor_of(scale_, {rows}), tensor_of(change_, {rows, kHorizons}), tensor_of(value_, {rows})};
}

}  // namespace risorius
