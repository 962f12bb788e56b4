// Spoils clean marker frames as an optical system does: occlusions of single markers whose lengths are log-normal (many
// short, few long gaps) and of whole regions (a hand before the face), false tracks (jumps to a reflection, ghosts on a
// neighbour, swapped neighbours), white and coloured noise. Truth is kept: the clean frame's states say what a perfect
// repair would find, and every marker has a cause. Draws in frame order; applying allocates nothing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "capture/frames.h"
#include "replay/performer/random.h"

namespace risorius {

struct DefectOptions {
  double noise_mm = 0.1;             ///< standard deviation per axis, 0 to 10
  double occlusion_share = 0.03;     ///< of all samples, 0 to 0.5
  double false_track_share = 0.005;  ///< of the visible samples, 0 to 0.2
  double coloured_noise_mm = 0;      ///< standard deviation per axis of noise that lasts about 0.25 s, 0 to 10
  double regions_per_minute = 0;     ///< occlusions of all markers within 40 mm of one, 0 to 60
};

/// What became of a marker in a frame.
enum class DefectCause : char {
  kGood = '.',
  kOccluded = 'o',
  kRegionOccluded = 'r',
  kJump = 'j',
  kGhost = 'g',
  kSwap = 's',
  kAbsent = '-',  ///< missing already before
};

class MarkerDefects {
 public:
  /// Neutral positions 3 x M say who is whose neighbour. Throws std::invalid_argument for options out of range.
  MarkerDefects(const Eigen::Matrix3Xd& neutral_mm, double rate_hz, const DefectOptions& options, std::uint64_t seed);

  /// Reads the positions of `clean`, where its state is not kMissing, and sets its states: kMeasured where the observed
  /// sample is true, kMissing where it is occluded, kRejected with the reason where it is false. Writes states and
  /// positions of `observed`.
  void apply(MarkerFrame& clean, MarkerFrame& observed) noexcept;
  /// Of the frame that was spoiled last, one per marker.
  std::span<const DefectCause> causes() const noexcept { return causes_; }
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
  void step_region() noexcept;
  bool is_covered(std::size_t marker) const noexcept;
  bool is_hidden(std::size_t marker) const noexcept {
    return is_absent_[marker] != 0 || tracks_[marker].occluded || is_covered(marker);
  }
  void start_false_track(std::size_t marker) noexcept;
  Position noisy(std::size_t marker, const Eigen::Vector3d& position_mm) noexcept;

  static constexpr std::size_t kNeighbours = 3;

  DefectOptions options_;
  double rate_hz_;
  std::uint64_t seed_;
  double mean_visible_frames_ = 0;
  double start_probability_ = 0;
  std::vector<std::vector<std::size_t>> neighbours_;  ///< the nearest few, by marker
  std::vector<Track> tracks_;
  Eigen::Matrix3Xd neutral_mm_;
  std::size_t region_centre_ = 0;
  std::int64_t region_frames_ = 0;  ///< how long the hand stays
  double noise_keep_ = 0;           ///< of the coloured noise, per frame
  Eigen::Matrix3Xd coloured_mm_;    ///< 3 x M, now
  std::vector<DefectCause> causes_;
  std::vector<char> is_absent_;  ///< already before, in this frame
  Random occlusions_, false_tracks_, noise_, regions_, coloured_;
};

}  // namespace risorius
