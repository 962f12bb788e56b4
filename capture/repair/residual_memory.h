// What a marker's past is worth for its future, when the other markers have had their say.
//
// The residual e(t) of a marker (measured less predicted from the others) is remembered as two exponential averages,
// a quick one and a slow one, s = (quick, slow): together they hold its level and its trend. While the marker is
// visible, the regression of e(t) on s(t - lag) is learnt for lags of 1, 2, 4 ... 128 ticks. In a gap it gives the
// best linear forecast of the residual and, honestly, the error that it had at that lag: no law of growth is assumed.
// While a marker has little data of its own, its regression leans on the pool of all markers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace risorius {

class ResidualMemory {
 public:
  static constexpr int kLags = 8;
  static constexpr int kLongestLag = 1 << (kLags - 1);  ///< ticks
  static constexpr double kTickS = 1.0 / 60;            ///< a tick is a frame, but at least this long

  struct Forecast {
    Eigen::Vector3d residual_mm = Eigen::Vector3d::Zero();
    double variance_mm2 = 0;  ///< of the true residual about it, per axis
  };

  /// Columns: the quick and the slow average of a residual.
  using Level = Eigen::Matrix<double, 3, 2>;
  /// One more residual, step_s after the one before; `goes_on`: there was one.
  static void follow(Level& level_mm, const Eigen::Vector3d& residual_mm, double step_s, bool goes_on) noexcept;

  /// Allocates. Marker i takes over what was known of old_index[i]; -1 is a marker never seen.
  void remap(const std::vector<int>& old_index);
  void reset() noexcept;

  /// Once per frame, before observe().
  void begin_frame(double step_s) noexcept;
  /// The residual of a visible marker, and the variance (per axis) that the model gave it.
  void observe(std::size_t i, const Eigen::Vector3d& residual_mm, double variance_mm2) noexcept;
  /// A residual seen `step_s` after the one last observed, before the next frame: the last word on a marker that goes.
  void refine(std::size_t i, const Eigen::Vector3d& residual_mm, double step_s) noexcept;
  /// What was remembered of marker i is raised by this: the model speaks differently from now on.
  void shift(std::size_t i, const Eigen::Vector3d& by_mm) noexcept { markers_[i].level_mm.colwise() += by_mm; }
  /// For a marker that was observed last `gap_s` ago and that the model predicts now with `variance_mm2`.
  Forecast forecast(std::size_t i, double gap_s, double variance_mm2) const noexcept {
    return forecast_from(markers_[i].level_mm, i, gap_s, variance_mm2);
  }
  /// The same from another level, as if that were the one remembered of marker i.
  Forecast forecast_from(const Level& level_mm, std::size_t i, double gap_s, double variance_mm2) const noexcept;

 private:
  static constexpr std::size_t kRing = kLongestLag + 1;
  /// Second moments over the samples, all three axes summed.
  struct Moments {
    Eigen::Matrix2d s_s = Eigen::Matrix2d::Zero();
    Eigen::Vector2d e_s = Eigen::Vector2d::Zero();
    double e_e = 0;
    double model = 0;   ///< what the model claimed of e_e
    double weight = 0;  ///< samples
    void fade(double keep) noexcept;
    void add(const Moments& other, double scale) noexcept;
  };
  struct Marker {
    Level level_mm = Level::Zero();
    std::int64_t last_frame = -2;
    std::array<Moments, kLags> moments;
  };
  struct Past {
    Level level_mm = Level::Zero();
    bool valid = false;
  };

  static std::array<Moments, kLags> prior_pool() noexcept;
  void learn_lags(std::size_t i, const Eigen::Vector3d& residual_mm, double variance_mm2) noexcept;
  void renew_pool() noexcept;
  Forecast forecast_at_lag(const Level& level_mm, const Marker& marker, std::size_t lag,
                           double variance_mm2) const noexcept;

  std::vector<Marker> markers_;
  std::vector<Past> ring_;  ///< kRing ticks x markers
  std::array<Moments, kLags> pool_ = prior_pool();
  std::int64_t frame_ = 0;
  std::int64_t tick_ = 0;
  bool is_tick_ = false;
  double since_tick_s_ = 0;
  double tick_s_ = kTickS;
  double quick_rate_ = 1, slow_rate_ = 1;
};

}  // namespace risorius
