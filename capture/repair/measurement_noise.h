// How noisy each marker's track is, from its third differences: their mean logarithm is that of the noise, which is
// there in every frame, and not that of the motion, which comes and goes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace risorius {

class MeasurementNoise {
 public:
  void resize(std::size_t markers) { tracks_.assign(markers, {}); }
  void reset() noexcept { std::fill(tracks_.begin(), tracks_.end(), Track{}); }

  /// Once per frame, step_s after the one before.
  void observe(const std::vector<Eigen::Vector3d>& position_mm, const std::vector<std::uint8_t>& measured,
               double step_s) noexcept {
    for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].observe(position_mm[i], measured[i] != 0, step_s);
  }
  /// Per axis; 0 before it is known.
  double variance_mm2(std::size_t i) const noexcept {
    const Track& track = tracks_[i];
    return track.samples < kLeastSamples ? 0 : std::exp(2 * (track.mean_log + kGaussianLog)) / kDifferenceVariance;
  }

 private:
  static constexpr double kMemoryS = 5;
  static constexpr int kLeastSamples = 30;
  static constexpr double kLeastMm = 1e-5;
  /// Of a Gaussian, the mean of ln |x| lies so far below ln sigma: (Euler's constant + ln 2) / 2.
  static constexpr double kGaussianLog = 0.6351814227;
  static constexpr double kDifferenceVariance = 20;  ///< of x(t) - 3 x(t - 1) + 3 x(t - 2) - x(t - 3)

  struct Track {
    Eigen::Vector3d last_mm = Eigen::Vector3d::Zero(), first_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d second_mm = Eigen::Vector3d::Zero();
    int in_a_row = 0;
    int samples = 0;
    double mean_log = 0;

    void observe(const Eigen::Vector3d& position_mm, bool measured, double step_s) noexcept {
      if (!measured) {
        in_a_row = 0;
        return;
      }
      if (in_a_row >= 3) {
        const Eigen::Array3d bend = (position_mm - 3 * last_mm + 3 * second_mm - first_mm).array().abs().max(kLeastMm);
        samples = std::min(samples + 1, 1 << 20);
        mean_log += std::max(1.0 / samples, std::min(1.0, step_s / kMemoryS)) * (bend.log().mean() - mean_log);
      }
      in_a_row = std::min(in_a_row + 1, 3);
      first_mm = second_mm;
      second_mm = last_mm;
      last_mm = position_mm;
    }
  };
  std::vector<Track> tracks_;
};

}  // namespace risorius
