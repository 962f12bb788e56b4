// What the continuation network sees of an AU's past, and the prediction that it corrects. One definition for the
// trainer and the runtime. Everything is relative to the AU's present value and in units of a scale taken from its own
// recent motion, so that a strong and a weak face look the same; nothing depends on the frame rate but the stated
// interval.
//
//   x(t + h) = x + v tau (1 - exp(-h / tau)) + s g(h),   tau = 80 ms                                               (3)
//
// v is the least-squares slope over the last 50 ms, s^2 = the mean square of what changed over the last 0.4 s, recent
// changes counted more, + 0.01^2; g is the network's.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "generate/au_kind.h"
#include "generate/transition.h"

namespace risorius {

inline constexpr std::array<double, 12> kContinuationLagsMs{17, 33, 50, 67, 83, 100, 133, 167, 200, 250, 300, 400};
inline constexpr std::array<double, 5> kContinuationHorizonsMs{50, 100, 150, 250, 500};
/// Lags; three lags of the other side; velocity, scale, value, interval, roughness, motion of all and of the kind;
/// kind.
inline constexpr Eigen::Index kContinuationWidth = 12 + 3 + 7 + static_cast<Eigen::Index>(kAuKinds);

/// A row per AU.
struct ContinuationFeatures {
  AuMatrix inputs;  ///< A x kContinuationWidth
  Eigen::VectorXf value, velocity_per_s, scale;
};

/// v tau (1 - exp(-h / tau)) of (3) for v = 1.
double damped_way(double ahead_s) noexcept;

class ContinuationFeatureMaker {
 public:
  /// AUs by name; any.
  explicit ContinuationFeatureMaker(const std::vector<std::string>& names);

  /// The next frame, later than the last; as many intensities as AUs, finite. Allocates nothing, like make().
  void observe(std::int64_t time_ns, std::span<const float> intensities) noexcept;
  void reset() noexcept { count_ = next_ = 0; }
  bool is_empty() const noexcept { return count_ == 0; }
  /// From the frame observed last. `features` as allocate() made it.
  void make(ContinuationFeatures& features) noexcept;
  ContinuationFeatures allocate() const;
  std::size_t size() const noexcept { return kinds_.size(); }

 private:
  static constexpr std::size_t kMoments = 512;  ///< half a second at 1000 frames/s

  std::size_t place(std::size_t back) const noexcept { return (next_ + kMoments - 1 - back) % kMoments; }
  double age_s(std::size_t back) const noexcept;
  void find_lags() noexcept;
  float at_lag(std::size_t lag, Eigen::Index au) const noexcept;
  float velocity_of(Eigen::Index au) const noexcept;
  float roughness_of(Eigen::Index au) const noexcept;

  std::vector<AuKind> kinds_;
  std::vector<std::size_t> other_;
  AuMatrix rows_;  ///< ring: kMoments x A
  std::vector<std::int64_t> times_ns_;
  std::size_t next_ = 0, count_ = 0;
  std::array<std::size_t, kContinuationLagsMs.size()> newer_{}, older_{};  ///< frames around each lag, counted back
  std::array<float, kContinuationLagsMs.size()> share_{};                  ///< of the older one
};

}  // namespace risorius
