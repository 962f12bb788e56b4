// Markers that move together exactly as a linear model says, for the tests of what learns that.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

namespace risorius::test {

/// 12 markers driven by two latent variables, with noise; hidden markers are not to be read (NaN).
class LinearFace {
 public:
  explicit LinearFace(unsigned seed) : random_(seed) {
    for (std::size_t i = 0; i < kMarkers; ++i) {
      mean_[i] = 50 * draw();
      for (auto& mode : modes_[i]) mode = 3 * draw();
    }
  }
  static constexpr std::size_t kMarkers = 12;
  void next() {
    const double a = normal_(random_), b = normal_(random_);
    for (std::size_t i = 0; i < kMarkers; ++i) {
      truth[i] = mean_[i] + a * modes_[i][0] + b * modes_[i][1];
      measured[i] = truth[i] + 0.05 * draw();
    }
  }
  std::vector<Eigen::Vector3d> truth = std::vector<Eigen::Vector3d>(kMarkers), measured = truth;
  std::vector<std::uint8_t> visible = std::vector<std::uint8_t>(kMarkers, 1);

 private:
  Eigen::Vector3d draw() { return {normal_(random_), normal_(random_), normal_(random_)}; }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0, 1};
  std::array<Eigen::Vector3d, kMarkers> mean_;
  std::array<std::array<Eigen::Vector3d, 2>, kMarkers> modes_;
};

}  // namespace risorius::test
