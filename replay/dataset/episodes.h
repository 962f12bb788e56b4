// Finds the episodes of every AU in a stream of AU frames: the longest runs of frames at or above a low threshold that
// reach the cut point of letter A. Two thresholds, so that noise around one does not chop an episode.
//
//   scaled   A ------------.--.--------------      low threshold = A - hysteresis
//          low ----- . . . . .  . . ---------
//                  . |  onset ... offset   | .
//
// A frame in which an AU is not observed (occluded, held, predicted, not solved) neither starts nor ends its episode
// nor counts for its peak; after `longest_unobserved_s` without sight the episode is closed where it was last seen.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "capture/stage.h"
#include "replay/dataset/episode.h"

namespace risorius {

/// Scaled intensities from which on an AU is coded A, B, C, D, E; growing, above 0.
using CutPoints = std::array<double, 5>;

struct EpisodeOptions {
  double scale = 5;  ///< from the solve's 0 to 1 to the letters' 0 to 5; > 0
  double cap = 5;    ///< of the scaled intensity; at least the cut point of E
  CutPoints cut_points{0.5, 1.5, 2.5, 3.5, 4.5};
  std::map<std::string, CutPoints> cut_points_of;  ///< a profile by column name ("AU12L") or AU ("AU12"); overrides
  double hysteresis = 0.25;                        ///< scaled; 0 to below the cut point of A
  double minimum_duration_s = 0.04;                ///< onset to offset; the shortest micro-expressions; >= 0
  double longest_unobserved_s = 0.5;               ///< >= 0
  double jaw_split = 0.6;  ///< share of the jaw's range that is AU26; the rest is AU27; in (0, 1)
};

/// push is refused (false) while more than one frame's episodes wait to be popped. A frame with another number of AUs
/// than there are names is counted as refused. `emitted` counts frames that were looked at.
class EpisodeDetector {
 public:
  /// Throws UserError for options out of range, naming option, value and range.
  EpisodeDetector(const std::vector<std::string>& au_names, const EpisodeOptions& options);

  bool push(const AuFrame& frame) noexcept;
  /// Episodes in the order in which they were closed.
  bool pop(Episode& episode) noexcept;
  /// Nothing happens by time alone.
  void tick(Tick) noexcept {}
  /// End of the take: closes what is open. The next frame begins a new take.
  void flush() noexcept;

  const StageLedger& ledger() const noexcept { return ledger_; }
  /// Runs that reached letter A and were shorter than the minimum duration.
  std::uint64_t too_short() const noexcept { return too_short_.value(); }

 private:
  struct Track {
    // What does not change
    std::uint8_t au_number = 0;
    ColumnSide side = ColumnSide::kNone;
    bool is_jaw = false;
    CutPoints cut_points{};
    double scale = 1;
    // The run of frames at or above the low threshold
    bool is_open = false;
    EpisodePoint onset, apex, last_seen;
    double peak = 0;
  };

  double scaled(const Track& track, double intensity) const noexcept;
  void follow(Track& track, const AuFrame& frame, std::size_t column) noexcept;
  void close(Track& track, std::size_t column, EpisodeEnd end) noexcept;
  void code(const Track& track, Episode& episode) const noexcept;

  EpisodeOptions options_;
  std::int64_t minimum_duration_ns_, longest_unobserved_ns_;
  std::vector<Track> tracks_;
  std::vector<Episode> ring_;
  std::size_t first_ = 0, waiting_ = 0;
  StageLedger ledger_;
  Counter too_short_;
};

/// episodes.csv: au,side,code,onset_frame,apex_frame,offset_frame,onset_s,apex_s,offset_s,peak,letter,closed_by.
/// Throws UserError.
void save_episodes(const std::filesystem::path& path, const std::vector<std::string>& au_names,
                   std::span<const Episode> episodes);

}  // namespace risorius
