#include "bench/fill_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "capture/repair/position_vector.h"

namespace risorius::bench {
namespace {

constexpr std::size_t kBins = 16;
constexpr int kResamples = 2000;

std::uint8_t octave(std::size_t frames) {
  return static_cast<std::uint8_t>(std::min<double>(std::log2(static_cast<double>(frames)), kBins - 1));
}

double gaussian_crps(double error, double deviation) {
  if (!(deviation > 0)) return std::abs(error);
  const double z = error / deviation;
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2);
  return deviation * (z * (2 * below - 1) + 2 * density - 1 / std::sqrt(std::numbers::pi));
}

double percentile_99(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(0.99 * static_cast<double>(values.size() - 1))];
}

/// Jump from frame f - 1 to f that the true motion does not explain.
double step_mm(const std::vector<MarkerFrame>& clean, const std::vector<MarkerFrame>& shown, std::size_t i,
               std::size_t f) {
  const Eigen::Vector3d moved = to_vector(clean[f].position_mm[i]) - to_vector(clean[f - 1].position_mm[i]);
  return (to_vector(shown[f].position_mm[i]) - to_vector(shown[f - 1].position_mm[i]) - moved).norm();
}

}  // namespace

double DrawScore::sum_mm() const {
  double sum = 0;
  for (const ErrorSample& s : samples) sum += std::hypot(s.error_mm[0], s.error_mm[1], s.error_mm[2]);
  return sum;
}

double DrawScore::sum_squared_mm2() const {
  double sum = 0;
  for (const ErrorSample& s : samples) {
    for (const double e : s.error_mm) sum += e * e;
  }
  return sum;
}

DrawScore score_draw(const std::vector<MarkerFrame>& clean, const std::vector<MarkerFrame>& cut,
                     const std::vector<MarkerFrame>& filled, bool is_causal) {
  DrawScore score;
  const auto hidden = [&](std::size_t f, std::size_t i) {
    return cut[f].state[i] == MarkerState::kMissing && clean[f].state[i] == MarkerState::kMeasured;
  };
  for (std::size_t i = 0; i < clean.front().count; ++i) {
    for (std::size_t begin = 1; begin < clean.size(); ++begin) {
      if (!hidden(begin, i)) continue;
      std::size_t end = begin;
      while (end < clean.size() && hidden(end, i)) ++end;
      for (std::size_t f = begin; f < end; ++f) {
        if (filled[f].state[i] != MarkerState::kFilled) {
          ++score.left_missing;
          continue;
        }
        const Eigen::Vector3f error =
            (to_vector(filled[f].position_mm[i]) - to_vector(clean[f].position_mm[i])).cast<float>();
        const std::size_t away = is_causal ? f - begin + 1 : std::min(f - begin + 1, end - f);
        score.samples.push_back({{error.x(), error.y(), error.z()}, filled[f].standard_deviation_mm[i], octave(away)});
      }
      if (filled[begin].state[i] == MarkerState::kFilled && cut[begin - 1].state[i] == MarkerState::kMeasured) {
        score.start_step_mm.push_back(step_mm(clean, filled, i, begin));
      }
      if (end < clean.size() && filled[end - 1].state[i] == MarkerState::kFilled) {
        score.end_step_mm.push_back(step_mm(clean, filled, i, end));
      }
      begin = end;
    }
  }
  return score;
}

double mean_mm(const MethodScore& score) {
  double sum = 0, count = 0;
  for (const DrawScore& draw : score) sum += draw.sum_mm(), count += static_cast<double>(draw.samples.size());
  return sum / count;
}

double rmse_mm(const MethodScore& score) {
  double sum = 0, count = 0;
  for (const DrawScore& draw : score) sum += draw.sum_squared_mm2(), count += static_cast<double>(draw.samples.size());
  return std::sqrt(sum / count);
}

double coverage_percent(const MethodScore& score) {
  constexpr double kTwoSided90 = 1.6449;
  double inside = 0, count = 0;
  for (const DrawScore& draw : score) {
    for (const ErrorSample& s : draw.samples) {
      for (const double e : s.error_mm) inside += std::abs(e) <= kTwoSided90 * double{s.deviation_mm}, count += 1;
    }
  }
  return 100 * inside / count;
}

double crps_mm(const MethodScore& score, bool calibrated) {
  std::array<double, kBins> all_squared{}, all_count{};
  const auto add = [](const DrawScore& draw, double sign, auto& squared, auto& count) {
    for (const ErrorSample& s : draw.samples) {
      for (const double e : s.error_mm) squared[s.bin] += sign * e * e, count[s.bin] += sign;
    }
  };
  for (const DrawScore& draw : score) add(draw, 1, all_squared, all_count);
  double sum = 0, axes = 0;
  for (const DrawScore& draw : score) {
    auto squared = all_squared, count = all_count;
    add(draw, -1, squared, count);
    for (const ErrorSample& s : draw.samples) {
      const double deviation =
          calibrated ? std::sqrt(std::max(squared[s.bin], 0.0) / std::max(count[s.bin], 1.0)) : double{s.deviation_mm};
      for (const double e : s.error_mm) sum += gaussian_crps(e, deviation), axes += 1;
    }
  }
  return sum / axes;
}

double start_step_p99_mm(const MethodScore& score) {
  std::vector<double> steps;
  for (const DrawScore& draw : score) steps.insert(steps.end(), draw.start_step_mm.begin(), draw.start_step_mm.end());
  return percentile_99(std::move(steps));
}

double end_step_p99_mm(const MethodScore& score) {
  std::vector<double> steps;
  for (const DrawScore& draw : score) steps.insert(steps.end(), draw.end_step_mm.begin(), draw.end_step_mm.end());
  return percentile_99(std::move(steps));
}

Interval ratio_interval(const MethodScore& a, const MethodScore& b) {
  std::vector<std::array<double, 4>> sums;
  for (std::size_t d = 0; d < a.size(); ++d) {
    sums.push_back({a[d].sum_mm(), static_cast<double>(a[d].samples.size()), b[d].sum_mm(),
                    static_cast<double>(b[d].samples.size())});
  }
  std::mt19937_64 random(7);
  std::vector<double> ratios;
  for (int k = 0; k < kResamples; ++k) {
    std::array<double, 4> total{};
    for (std::size_t d = 0; d < sums.size(); ++d) {
      const auto& drawn = sums[random() % sums.size()];
      for (std::size_t n = 0; n < 4; ++n) total[n] += drawn[n];
    }
    ratios.push_back((total[0] / total[1]) / (total[2] / total[3]));
  }
  std::ranges::sort(ratios);
  return {ratios[kResamples / 40], ratios[kResamples - 1 - kResamples / 40]};
}

}  // namespace risorius::bench
