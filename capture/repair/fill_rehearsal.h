// How far a fill can be believed, found out by rehearsing: a few visible markers at a time are hidden from a covariance
// of its own, which fills them as the live model would, and what it gets wrong is seen at once. Errors of markers that
// the model went on learning from say too little: in a gap it learns nothing of the marker, and it takes the more on
// trust the longer the gap is. Learnt per octave of the gap's length, over all markers, each in units of its own stated
// deviation:
//   weight: fill = stayed + weight (model - stayed), with `stayed` where the marker was of late. In a still face most
//   of
//           what the others seem to say is noise, and to stay is better.
//   scale:  of the stated variance, so that it is the one that the errors have.
// Before anything was rehearsed, and mixed with what little was, stands a belief (weight 1, a scale that grows).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "capture/repair/fill_model.h"
#include "capture/repair/fill_trust.h"
#include "capture/repair/measurement_noise.h"

namespace risorius {

class FillRehearsal {
 public:
  /// Throws UserError for an option out of its range.
  explicit FillRehearsal(MarkerCovarianceOptions options = {});

  /// Allocates. What was learnt stays; marker i takes over what the covariance knew of old_index[i].
  void remap(const std::vector<int>& old_index);
  /// As MarkerCovariance::know.
  void know(std::shared_ptr<const KnownMotion> motion, const std::vector<std::string>& names) {
    covariance_.know(std::move(motion), names);
  }
  void reset() noexcept;

  /// Keeps a frame to practise on: as FillModel::observe takes it.
  void take(const std::vector<Eigen::Vector3d>& position_head_mm, const std::vector<std::uint8_t>& measured) noexcept;
  /// Once per frame, after it is on its way; step_s after the one before. `is_informed`: it was taken. Of `live` the
  /// markers' own habits are borrowed.
  void practise(const FillModel& live, double step_s, bool is_informed) noexcept;

  /// What `model` says of marker i that was at `stayed_head_mm` of late and was measured last gap_s ago, as far as it
  /// can be believed.
  MarkerFill weigh(std::size_t i, const MarkerFill& model, const Eigen::Vector3d& stayed_head_mm,
                   double gap_s) const noexcept;

 private:
  static constexpr std::size_t kOctaves = 8;  ///< gaps of 1, 2, 4 ... 128 ticks
  static constexpr std::size_t kMostHidden = 6;

  static constexpr std::size_t kMoves = 4;  ///< (model - stayed)^2 of 1/4, 1, 4, 16 believed variances
  /// Between which cells a fill lies: bilinear.
  struct Place {
    std::array<std::size_t, 4> cell;
    std::array<double, 4> share;
  };
  struct Actor {
    std::size_t marker = 0;
    ResidualMemory::Level level_mm = ResidualMemory::Level::Zero();
    Eigen::Vector3d stayed_head_mm = Eigen::Vector3d::Zero();
    bool is_watched = false;  ///< there is a level
    bool has_truth = false;   ///< was measured from the gap's begin to now
  };
  using Cast = std::array<Actor, kMostHidden>;

  static FillTrust belief(std::size_t c) noexcept;
  void reset_books() noexcept;
  void forget(double seconds) noexcept;
  void begin_gap() noexcept;
  void choose_next() noexcept;
  void take_over_shifts() noexcept;
  void watch_next() noexcept;
  void learn() noexcept;
  void compare(const FillModel& live, double step_s) noexcept;
  void note_error(std::size_t i, const MarkerFill& said, const Eigen::Vector3d& stayed_head_mm, double gap_s,
                  double frame) noexcept;
  static Place place_of(double gap_s, double move) noexcept;

  MarkerCovariance covariance_;
  MeasurementNoise noise_;
  std::vector<Eigen::Vector3d> position_head_mm_;  ///< of the frame last taken, and
  std::vector<std::uint8_t> measured_;             ///< whether it showed the marker, and
  std::vector<std::uint8_t> shown_;                ///< whether it was shown to the covariance
  Cast hidden_, next_;                             ///< who is hidden now, and who will be
  std::size_t hidden_count_ = 0, next_count_ = 0;
  double since_tick_s_ = 0;      ///< from the frame last learnt from, to the one last taken
  std::size_t next_marker_ = 0;  ///< whose turn it is
  std::size_t stride_ = 1;       ///< from one turn to the next, so that all markers have theirs
  std::size_t next_length_ = 0;
  double gap_s_ = 0, ends_s_ = 0;  ///< of the gap at hand; before the first one: of the time before it
  double memory_s_;
  std::array<FillTrust, kOctaves * kMoves> cells_;  ///< gaps of one length and moves of one size; forgotten
};

}  // namespace risorius
