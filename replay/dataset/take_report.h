// One take's report, as a picture: intensities with their bands and letters, what the rig leaves of the markers, what
// was filled, slipping stabilisers and a wandering neutral. Filled frame by frame, drawn at the end.
#pragma once

#include <string>
#include <vector>

#include "replay/dataset/episode.h"
#include "replay/dataset/episodes.h"
#include "replay/picture/canvas.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/pipeline/slip_watch.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// The chance (0 to 1) that an intensity with this standard deviation lies within half a FACS letter (0.1) of its
/// value.
double letter_confidence(double standard_deviation) noexcept;

class TakeReport {
 public:
  TakeReport(const Rig& rig, const MarkerSet& set, std::string title);

  void add(const SolvedFrame& frame);

  /// After the last frame. AUs that never reach a letter are named, not drawn.
  Canvas draw();
  const std::vector<Episode>& episodes() const noexcept { return episodes_; }
  const SlipWatch& slip() const noexcept { return slip_; }
  /// Chance that an episode's letter is right, by the standard deviation at its apex.
  double confidence_of(const Episode& episode) const;

 private:
  void draw_aus(Canvas& canvas, const std::vector<std::vector<std::size_t>>& panels, double top) const;
  void draw_quality(Canvas& canvas, double top) const;
  void draw_episodes(Canvas& canvas, double top) const;
  std::vector<std::vector<std::size_t>> panels() const;

  Rig rig_;
  std::string title_;
  SlipWatch slip_;
  EpisodeDetector detector_;
  std::vector<Episode> episodes_;
  std::vector<double> time_s_, residual_mm_, filled_share_, observed_share_;
  std::vector<std::uint64_t> sequence_;
  std::vector<std::vector<double>> intensity_, deviation_;  // per AU; NaN where not observed
  std::int64_t first_ns_ = 0;
};

}  // namespace risorius
