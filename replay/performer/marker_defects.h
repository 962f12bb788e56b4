// Spoils clean marker frames as an optical system does: occlusions whose lengths are log-normal (many short, few long
// gaps), false tracks (jumps to a reflection, ghosts on a neighbour, swapped neighbours) and white noise. Truth is
// kept: the clean frame's states say what a perfect repair would find. Draws in frame order; applying allocates
// nothing.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/frames.h"
#include "replay/performer/random.h"

namespace risorius {

struct DefectOptions {
  double noise_mm = 0.1;             ///< standard deviation per axis, 0 to 10
  double occlusion_share = 0.03;     ///< of all samples, 0 to 0.5
  double false_track_share = 0.005;  ///< of the visible samples, 0 to 0.2
};

class MarkerDefects {
 public:
  /// Neutral positions 3 x M say who is whose neighbour. Throws std::invalid_argument for options out of range.
  MarkerDefects(const Eigen::Matrix3Xd& neutral_mm, double rate_hz, const DefectOptions& options, std::uint64_t seed);

  /// Reads the positions of `clean` and sets its states: kMeasured where the observed sample is true, kMissing where it
  /// is occluded, kRejected with the reason where it is false. Writes states and positions of `observed`.
  void apply(MarkerFrame& clean, MarkerFrame& observed) noexcept;
  void rewind();

 private:
  struct Track {
    bool occluded = false;
    std::int64_t frames_to_change = 0;  ///< of `occluded`
    int false_frames = 0;               ///< still to come
    RejectReason reason = RejectReason::kNone;
    std::size_t partner = 0;
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();
  };

  std::int64_t draw_gap_frames() noexcept;
  std::int64_t draw_visible_frames() noexcept;
  Eigen::Vector3d draw_offset(double least_mm, double most_mm) noexcept;
  void step_occlusion(Track& track) noexcept;
  void start_false_track(std::size_t marker) noexcept;
  Position noisy(const Eigen::Vector3d& position_mm) noexcept;

  static constexpr std::size_t kNeighbours = 3;

  DefectOptions options_;
  double rate_hz_;
  std::uint64_t seed_;
  double mean_visible_frames_ = 0;
  double start_probability_ = 0;
  std::vector<std::vector<std::size_t>> neighbours_;  ///< the nearest few, by marker
  std::vector<Track> tracks_;
  Random occlusions_, false_tracks_, noise_;
};

}  // namespace risorius
