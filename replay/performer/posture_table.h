// Which intensities go together in a face: the levels that each AU takes (quantiles) and how the AUs' ranks correlate.
// A posture is drawn as a Gaussian copula: correlated normal scores, each led through its AU's own distribution (Nelsen
// 2006, section 2). What is stored are distributions, never a stretch of a recording.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/performer/random.h"

namespace risorius {

struct PostureTable {
  static constexpr std::array<double, 13> kShares{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1};
  using Levels = std::array<double, kShares.size()>;

  std::vector<std::string> aus;  ///< without sides
  std::vector<Levels> levels;    ///< one per AU, intensity over rest at kShares, not falling
  Eigen::MatrixXd correlation;   ///< aus x aus, of normal scores; positive definite
};

/// Where each value lies among all, 0 to 1; equal values share the middle of their ranks.
std::vector<double> rank_shares(std::span<const double> values);
/// Normal scores of these: what PostureTable::correlation correlates.
std::vector<double> normal_scores(std::span<const double> values);

/// A posture that goes on: renewed in part, led where the script asks for a level. Starts at the middle of all
/// distributions.
class PostureSampler {
 public:
  /// The table must outlive it. Throws std::invalid_argument: sizes that do not fit, correlation not positive definite.
  explicit PostureSampler(const PostureTable& table);

  std::optional<std::size_t> find(std::string_view au) const;
  /// `kept`, 0 to 1, is the correlation with what was there before. Draws one number per AU of the table.
  void renew(double kept, Random& random);
  /// An AU of the table and the share of its distribution where it shall be, 0 to 1.
  struct Lead {
    std::size_t au;
    double share;
  };
  /// Takes these AUs there and the others along by what is known of them: conditional draw by adding the regression of
  /// the difference (Matheron's rule). At most one lead per AU.
  void lead(std::span<const Lead> leads);

  double level(std::size_t au) const;
  /// Where in its distribution a level is, 0 to 1.
  double share_of(std::size_t au, double level) const;

 private:
  const PostureTable& table_;
  Eigen::MatrixXd root_;    ///< lower Cholesky factor of the correlation
  Eigen::VectorXd scores_;  ///< the posture at hand
};

}  // namespace risorius
