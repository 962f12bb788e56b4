#include "replay/performer/wander_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace risorius {
namespace {

constexpr double kHalfSecondS = 0.5, kDriftS = 5, kLongDriftS = 20;

/// Variance and memory of wandering from differences over two lags: D(t) = 2 s^2 (1 - r(t)), where r of two low-passes
/// in a row is (1 + t / T) exp(-t / T).
Wander wander_of(double near_difference, double near_s, double far_difference, double far_s) {
  const double deviation = std::sqrt(std::max(far_difference, 1e-12) / 2);
  const double wanted = std::clamp(near_difference / std::max(far_difference, 1e-12), 1e-3, 0.98);
  double low = 1e-3, high = far_s;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), u = near_s / middle, v = far_s / middle;
    const double ratio = (1 - (1 + u) * std::exp(-u)) / (1 - (1 + v) * std::exp(-v));
    (ratio > wanted ? low : high) = middle;
  }
  return {deviation, low};
}

/// Whether an AU rests over frames [from, to].
bool is_at_rest(const PreparedSeries& series, std::size_t k, std::size_t from, std::size_t to) {
  for (std::size_t f = from; f <= to; ++f) {
    if (series.rows[f][k] >= ActionOptions{}.low) return false;
  }
  return true;
}

double mean_square(std::vector<double> differences) {
  for (double& value : differences) value = std::abs(value);
  const double one = quantile_of(std::move(differences), 0.683);
  return one * one;
}

/// Changes of the resting level over `lag_s`.
std::vector<double> drift_over(const PreparedSeries& series, double lag_s) {
  std::vector<double> changes;
  const auto lag = static_cast<std::size_t>(lag_s * series.rate_hz);
  const auto stride = static_cast<std::size_t>(kDriftS * series.rate_hz);
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    for (std::size_t f = 0; f + lag < series.rows.size(); f += stride)
      changes.push_back(series.rest[f + lag][k] - series.rest[f][k]);
  }
  return changes;
}

}  // namespace

WanderMoments wander_moments(const PreparedSeries& series) {
  std::vector<double> frame, half_second;
  const auto lag = static_cast<std::size_t>(kHalfSecondS * series.rate_hz);
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    for (std::size_t f = 0; f + lag < series.rows.size(); ++f) {
      if (!is_at_rest(series, k, f, f + lag)) continue;
      frame.push_back(series.rows[f + 1][k] - series.rows[f][k]);
      half_second.push_back(series.rows[f + lag][k] - series.rows[f][k]);
    }
  }
  return {mean_square(std::move(frame)), mean_square(std::move(half_second)), mean_square(drift_over(series, kDriftS)),
          mean_square(drift_over(series, kLongDriftS))};
}

Wander micro_motion_of(const WanderMoments& moments, double rate_hz) {
  return wander_of(moments.frame, 1 / rate_hz, moments.half_second, kHalfSecondS);
}

Wander rest_drift_of(const WanderMoments& moments) {
  return wander_of(moments.five_seconds, kDriftS, moments.twenty_seconds, kLongDriftS);
}

std::vector<double> rest_drift_steps(const PreparedSeries& series) { return drift_over(series, kDriftS); }

RestSpectrum rest_spectrum(const PreparedSeries& series, std::size_t count) {
  const std::size_t length = 2 * count;
  std::vector<double> hann(length);
  double power = 0;
  for (std::size_t i = 0; i < length; ++i) {
    hann[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(length));
    power += hann[i] * hann[i];
  }
  std::vector<std::vector<double>> of_aus(count);  // per frequency
  for (std::size_t k = 0; k < series.names.size(); ++k) {
    std::vector<double> sum(count, 0);
    double windows = 0;
    for (std::size_t f = 0; f + length <= series.rows.size(); f += count) {
      if (!is_at_rest(series, k, f, f + length - 1)) continue;
      double mean = 0;
      for (std::size_t i = 0; i < length; ++i) mean += series.rows[f + i][k] / static_cast<double>(length);
      windows += 1;
      for (std::size_t j = 0; j < count; ++j) {
        std::complex<double> line = 0;
        const double turn = -2 * std::numbers::pi * static_cast<double>(j + 1) / static_cast<double>(length);
        for (std::size_t i = 0; i < length; ++i)
          line += hann[i] * (series.rows[f + i][k] - mean) * std::polar(1.0, turn * static_cast<double>(i));
        sum[j] += 2 * std::norm(line) / (power * series.rate_hz);
      }
    }
    if (windows == 0) continue;
    for (std::size_t j = 0; j < count; ++j) of_aus[j].push_back(sum[j] / windows);
  }
  RestSpectrum spectrum;
  if (of_aus[0].empty()) return spectrum;
  for (std::size_t j = 0; j < count; ++j) {
    spectrum.frequency_hz.push_back(static_cast<double>(j + 1) * series.rate_hz / static_cast<double>(length));
    spectrum.density.push_back(quantile_of(of_aus[j], 0.5));
  }
  return spectrum;
}

}  // namespace risorius
