// One take of a dataset folder, written frame by frame as the frames come: cleaned.c3d, au.csv, au_sd.csv, pose.csv,
// quality.csv, episodes.csv, rig.json and, last, take.json. replay/README.md describes the files.
// Rows begin with the frame's sequence number, and C3D frame i is number first_sequence + i: frames that were lost on
// the way are there as missing. A take at the level of AUs (a set without names) has no cleaned.c3d.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/marker_set.h"
#include "replay/atomic_file.h"
#include "replay/dataset/disk_reserve.h"
#include "replay/dataset/episode.h"
#include "replay/dataset/episodes.h"
#include "replay/dataset/marker_energy.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/takes/au_csv.h"
#include "replay/takes/c3d_writer.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// Ends the name of a take's folder until it is finished.
inline constexpr const char* kUnfinishedTake = ".partial";

struct TakeDatasetOptions {
  std::string source;         ///< where the frames came from: the take's file name or the live source's name
  std::string metadata_json;  ///< a JSON object; its members are added to take.json
  EpisodeOptions episodes;
};

class TakeDataset {
 public:
  /// Writes to `folder`.partial, which becomes `folder` when the take is finished; neither must exist. Throws
  /// UserError.
  TakeDataset(const std::filesystem::path& folder, const MarkerSet& markers, const Rig& rig,
              TakeDatasetOptions options);
  ~TakeDataset();

  /// Whether the frame goes on where the last one ended; false after a restart (the sequence went back), a gap of more
  /// than ten seconds, or where more was lost than a take can be of use with: then finish this take and begin another.
  bool continues_with(const MarkerFrame& frame) const noexcept;
  /// Whether the frame was captured before the last one, by its own word. It can be written all the same: rows go by
  /// the sequence.
  bool time_goes_back(const MarkerFrame& frame) const noexcept;
  /// Throws UserError if the disk refuses.
  void write(const SolvedFrame& frame);
  /// Completes all files.
  void finish();
  /// After write() has thrown: completes the take with what was on the disk at the last second of capture before, `why`
  /// in its take.json. Frames that it has no more are not counted any more. Throws UserError, as finish() does.
  void finish_early(const std::string& why);

  const std::filesystem::path& folder() const noexcept { return folder_; }
  std::uint64_t frame_count() const noexcept { return totals_.frames; }
  std::uint64_t lost_count() const noexcept { return totals_.lost; }
  /// Frames whose capture time is not after that of the one before.
  std::uint64_t time_stands_count() const noexcept { return totals_.time_stands; }
  /// Frames with AUs, solved or mapped.
  std::uint64_t solved_count() const noexcept {
    return status_count(SolverStatus::kConverged) + status_count(SolverStatus::kMapped);
  }
  /// Of the frames that came.
  std::uint64_t status_count(SolverStatus status) const noexcept {
    return totals_.by_status[static_cast<std::size_t>(status)];
  }
  std::uint64_t filled_count() const noexcept { return totals_.filled; }
  std::uint64_t sample_count() const noexcept { return totals_.samples; }
  double largest_kkt_residual() const noexcept { return totals_.largest_kkt_residual; }
  const MarkerEnergy& energy() const noexcept { return totals_.energy; }
  const Rig& rig() const noexcept { return rig_; }
  double rate_hz() const noexcept { return rate_hz_; }
  const std::vector<Episode>& episodes() const noexcept { return episodes_; }

 private:
  /// What the frames so far add up to.
  struct Totals {
    std::uint64_t frames = 0, lost = 0;                                ///< frames: with those lost
    std::uint64_t time_stands = 0;                                     ///< or goes back
    std::uint64_t samples = 0, filled = 0, rejected = 0, missing = 0;  ///< of markers
    std::array<std::uint64_t, kSolverStatusCount> by_status{};
    double largest_kkt_residual = 0;
    std::uint64_t next_sequence = 0;
    MarkerEnergy energy;
  };
  /// Up to where all files have the same frames, on the disk.
  struct Checkpoint {
    Totals totals;
    std::vector<std::uint64_t> file_bytes;
  };
  std::vector<AtomicFile*> files();
  void keep_checkpoint();
  const FrameHeader& last_header() const noexcept { return first_ ? first_->markers.header : last_header_; }
  void open_files(double rate_hz);
  void write_row(const SolvedFrame& frame);
  void write_quality(const SolvedFrame& frame, double time_s);
  void write_pose(const AuFrame& frame);
  void write_lost_until(std::uint64_t sequence);
  void find_episodes(const AuFrame& frame);
  void keep_episodes();
  void write_marker_facts(nlohmann::json& json) const;
  void write_take_json();

  std::filesystem::path folder_, partial_folder_;
  UnfinishedPath unfinished_;
  MarkerSet markers_;
  Rig rig_;
  TakeDatasetOptions options_;
  double rate_hz_ = 0;
  std::optional<SolvedFrame> first_;  ///< held until the second frame, if the set states no rate
  std::unique_ptr<C3dWriter> c3d_;
  std::unique_ptr<AuCsvWriter> au_csv_;
  std::unique_ptr<AtomicFile> au_sd_csv_, pose_csv_, quality_csv_;
  std::string line_;
  std::unique_ptr<EpisodeDetector> episode_detector_;
  std::vector<Episode> episodes_;
  Totals totals_;
  std::optional<Checkpoint> checkpoint_;
  std::optional<DiskReserve> reserve_;
  std::string ended_early_;
  std::uint64_t first_sequence_ = 0;
  std::int64_t first_capture_time_ns_ = 0;
  FrameHeader last_header_;
  bool finishing_ = false, finished_ = false;
};

}  // namespace risorius
