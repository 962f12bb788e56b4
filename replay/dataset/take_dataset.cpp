#include "replay/dataset/take_dataset.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <unistd.h>
#include <utility>

#include "capture/errors.h"
#include "capture/frame_words.h"
#include "capture/version.h"

namespace risorius {
namespace {

constexpr double kLongestGapSeconds = 10;
/// Whatever the rate: rows for frames that never came must not fill the disk. A take has at most so many, and so many
/// more for each frame that came.
constexpr std::uint64_t kMostLost = 2'000, kMostLostPerFrame = 20;
/// For rig.json, take.json and the episodes of some hours.
constexpr std::size_t kReserveBytes = 4 << 20;

void append_row(std::string& line, std::uint64_t frame) {
  line.clear();
  fmt::format_to(std::back_inserter(line), "{}", frame);
}

}  // namespace

TakeDataset::TakeDataset(const std::filesystem::path& folder, const MarkerSet& markers, const Rig& rig,
                         TakeDatasetOptions options)
    : folder_(folder),
      partial_folder_(folder.string() + kUnfinishedTake),
      unfinished_(partial_folder_),
      markers_(markers),
      rig_(rig),
      options_(std::move(options)),
      totals_{.energy = MarkerEnergy(rig, markers.names)} {
  std::error_code error;
  std::filesystem::create_directories(folder.parent_path(), error);
  if (std::filesystem::exists(folder) || !std::filesystem::create_directory(partial_folder_, error)) {
    throw UserError(folder.string(),
                    error ? "cannot make this folder: " + error.message() : "this folder is there already",
                    "give a folder that does not exist yet, on a disk that can be written");
  }
  if (markers.rate_hz > 0) open_files(markers.rate_hz);
}

/// A take that was given up leaves what is whole; nothing at all if nothing is.
TakeDataset::~TakeDataset() {
  if (finished_) return;
  c3d_.reset();
  au_csv_.reset();
  for (auto* file : {&au_sd_csv_, &pose_csv_, &quality_csv_}) file->reset();
  reserve_.reset();
  ::rmdir(partial_folder_.c_str());  // only if it is empty
}

void TakeDataset::open_files(double rate_hz) {
  rate_hz_ = rate_hz;
  reserve_.emplace(partial_folder_ / "reserve", kReserveBytes);
  MarkerSet written = markers_;
  written.rate_hz = rate_hz;
  if (!markers_.names.empty()) c3d_ = std::make_unique<C3dWriter>(partial_folder_ / "cleaned.c3d", written, kVersion);
  au_csv_ = std::make_unique<AuCsvWriter>(partial_folder_ / "au.csv", rig_.au_names());
  au_sd_csv_ = std::make_unique<AtomicFile>(partial_folder_ / "au_sd.csv");
  pose_csv_ = std::make_unique<AtomicFile>(partial_folder_ / "pose.csv");
  quality_csv_ = std::make_unique<AtomicFile>(partial_folder_ / "quality.csv");
  episode_detector_ = std::make_unique<EpisodeDetector>(rig_.au_names(), options_.episodes);
  line_ = "Frame";
  for (const auto& name : rig_.au_names()) line_ += "," + name;
  au_sd_csv_->write(line_ + "\n");
  pose_csv_->write(
      "frame,translation_x_mm,translation_y_mm,translation_z_mm,rotation_x,rotation_y,rotation_z,rotation_w\n");
  quality_csv_->write(
      "frame,time_s,measured,filled,rejected,missing,solver,residual_rms_mm,kkt_residual,marker_states,au_states,"
      "timecode\n");
}

bool TakeDataset::continues_with(const MarkerFrame& frame) const noexcept {
  if (totals_.frames == 0 && !first_) return true;
  const std::uint64_t sequence = frame.header.sequence;
  const FrameHeader& last = last_header();
  if (sequence <= last.sequence) return false;
  const std::uint64_t came = first_ ? 1 : totals_.frames - totals_.lost;
  if (sequence - last.sequence - 1 > kMostLost + kMostLostPerFrame * came - totals_.lost) return false;
  return first_ || static_cast<double>(sequence - totals_.next_sequence) <= kLongestGapSeconds * rate_hz_;
}

bool TakeDataset::time_goes_back(const MarkerFrame& frame) const noexcept {
  return (totals_.frames > 0 || first_) && frame.header.capture_time_ns < last_header().capture_time_ns;
}

void TakeDataset::write(const SolvedFrame& frame) {
  if (rate_hz_ == 0) {
    if (!first_) {
      first_ = frame;
      return;
    }
    const auto& first = first_->markers.header;
    const auto& second = frame.markers.header;
    const double seconds = static_cast<double>(difference_ns(second.capture_time_ns, first.capture_time_ns)) * 1e-9;
    // Rounded to a hundredth, as trackers state rates: one interval says no more.
    const double rate = static_cast<double>(second.sequence - first.sequence) / seconds;
    open_files(seconds > 0 ? std::clamp(std::round(rate * 100) / 100, 0.01, 1e5) : 100);
    write_row(*first_);
    first_.reset();
  }
  write_row(frame);
}

void TakeDataset::write_row(const SolvedFrame& frame) {
  const FrameHeader& header = frame.markers.header;
  if (totals_.frames == 0) {
    first_sequence_ = totals_.next_sequence = header.sequence;
    first_capture_time_ns_ = header.capture_time_ns;
  } else if (header.capture_time_ns <= last_header_.capture_time_ns) {
    ++totals_.time_stands;
  }
  write_lost_until(header.sequence);
  const double time_s = static_cast<double>(difference_ns(header.capture_time_ns, first_capture_time_ns_)) * 1e-9;
  if (c3d_) c3d_->write(frame.markers);
  au_csv_->write(frame.aus);
  write_pose(frame.aus);
  write_quality(frame, time_s);
  find_episodes(frame.aus);
  totals_.energy.add(frame);
  ++totals_.by_status[static_cast<std::size_t>(frame.aus.status)];
  totals_.largest_kkt_residual = std::max(totals_.largest_kkt_residual, frame.aus.kkt_residual);
  last_header_ = header;
  totals_.next_sequence = header.sequence + 1;
  ++totals_.frames;
  if (!checkpoint_ || static_cast<double>(totals_.frames - checkpoint_->totals.frames) >= rate_hz_) keep_checkpoint();
}

std::vector<AtomicFile*> TakeDataset::files() {
  std::vector<AtomicFile*> all{&au_csv_->file(), au_sd_csv_.get(), pose_csv_.get(), quality_csv_.get()};
  if (c3d_) all.push_back(&c3d_->file());
  return all;
}

void TakeDataset::keep_checkpoint() {
  Checkpoint checkpoint{totals_, {}};
  for (AtomicFile* file : files()) {
    file->flush();
    checkpoint.file_bytes.push_back(file->flushed_bytes());
  }
  checkpoint_ = std::move(checkpoint);
}

void TakeDataset::finish_early(const std::string& why) {
  if (!checkpoint_ || finishing_) throw UserError(folder_.string(), why, "nothing of this take was written");
  reserve_.reset();
  const std::vector<AtomicFile*> all = files();
  for (std::size_t i = 0; i < all.size(); ++i) all[i]->cut_to(checkpoint_->file_bytes[i]);
  totals_ = checkpoint_->totals;
  if (c3d_) c3d_->resume_at(totals_.frames);
  ended_early_ = why;
  finish();
}

void TakeDataset::write_lost_until(std::uint64_t sequence) {
  while (totals_.next_sequence < sequence) {
    SolvedFrame lost;
    lost.markers.header.sequence = lost.aus.header.sequence = totals_.next_sequence;
    lost.markers.count = static_cast<std::uint32_t>(markers_.names.size());
    lost.aus.count = static_cast<std::uint32_t>(rig_.au_count());
    const double time_s = static_cast<double>(totals_.next_sequence - first_sequence_) / rate_hz_;
    lost.aus.header.capture_time_ns = first_capture_time_ns_ + std::llround(time_s * 1e9);
    if (c3d_) c3d_->write(lost.markers);
    au_csv_->write(lost.aus);
    append_row(line_, totals_.next_sequence);
    line_ += ",,,,,,,\n";
    pose_csv_->write(line_);
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "{},{},,,,,lost,,,,,\n", totals_.next_sequence, time_s);
    quality_csv_->write(line_);
    append_row(line_, totals_.next_sequence);
    au_sd_csv_->write(line_ + std::string(rig_.au_count(), ',') + "\n");
    find_episodes(lost.aus);
    ++totals_.next_sequence;
    ++totals_.frames;
    ++totals_.lost;
  }
}

void TakeDataset::write_pose(const AuFrame& frame) {
  append_row(line_, frame.header.sequence);
  if (frame.status == SolverStatus::kConverged) {
    for (const double t : frame.world_from_head.translation_mm) fmt::format_to(std::back_inserter(line_), ",{}", t);
    for (const double q : frame.world_from_head.rotation_xyzw) fmt::format_to(std::back_inserter(line_), ",{}", q);
    line_ += '\n';
  } else {
    line_ += ",,,,,,,\n";
  }
  pose_csv_->write(line_);

  append_row(line_, frame.header.sequence);
  for (std::uint32_t i = 0; i < frame.count; ++i) {
    line_ += ',';
    if (frame.state[i] == AuState::kObserved && std::isfinite(frame.standard_deviation[i]))
      fmt::format_to(std::back_inserter(line_), "{}", frame.standard_deviation[i]);
  }
  line_ += '\n';
  au_sd_csv_->write(line_);
}

void TakeDataset::write_quality(const SolvedFrame& frame, double time_s) {
  std::array<std::uint64_t, 4> counts{};
  std::string marker_states, au_states;
  for (std::uint32_t m = 0; m < frame.markers.count; ++m) {
    ++counts[static_cast<std::size_t>(frame.markers.state[m])];
    marker_states += letter_of(frame.markers.state[m]);
  }
  for (std::uint32_t i = 0; i < frame.aus.count; ++i) au_states += letter_of(frame.aus.state[i]);
  const auto count_of = [&](MarkerState state) { return counts[static_cast<std::size_t>(state)]; };
  totals_.filled += count_of(MarkerState::kFilled);
  totals_.rejected += count_of(MarkerState::kRejected);
  totals_.missing += count_of(MarkerState::kMissing);
  totals_.samples += frame.markers.count;
  line_.clear();
  fmt::format_to(std::back_inserter(line_), "{},{},{},{},{},{},{},", frame.markers.header.sequence, time_s,
                 count_of(MarkerState::kMeasured), count_of(MarkerState::kFilled), count_of(MarkerState::kRejected),
                 count_of(MarkerState::kMissing), word_of(frame.aus.status));
  if (frame.aus.kind == AuFrameKind::kMapped) {
    line_ += ',';
  } else {
    fmt::format_to(std::back_inserter(line_), "{},{}", frame.aus.residual_rms_mm, frame.aus.kkt_residual);
  }
  fmt::format_to(std::back_inserter(line_), ",{},{},{}\n", marker_states, au_states,
                 text_of(frame.markers.header.timecode));
  quality_csv_->write(line_);
}

void TakeDataset::find_episodes(const AuFrame& frame) {
  while (!episode_detector_->push(frame)) keep_episodes();
  keep_episodes();
}

void TakeDataset::keep_episodes() {
  Episode episode;
  while (episode_detector_->pop(episode)) {
    // The tracker's clock may begin anywhere; a take's files count from its first frame.
    for (EpisodePoint* point : {&episode.onset, &episode.apex, &episode.offset})
      point->time_ns = difference_ns(point->time_ns, first_capture_time_ns_);
    episodes_.push_back(episode);
  }
}

void TakeDataset::finish() {
  if (std::exchange(finishing_, true)) return;
  reserve_.reset();
  if (rate_hz_ == 0) {
    open_files(100);  // one frame at most: any rate is as good as another
    if (first_) write_row(*first_);
  }
  episode_detector_->flush();
  keep_episodes();
  // What went on where the take was cut.
  std::erase_if(episodes_, [this](const Episode& episode) { return episode.offset.frame >= totals_.next_sequence; });
  save_episodes(partial_folder_ / "episodes.csv", rig_.au_names(), episodes_);
  if (c3d_) c3d_->finish();
  au_csv_->finish();
  au_sd_csv_->commit();
  pose_csv_->commit();
  quality_csv_->commit();
  save_rig(rig_, partial_folder_ / "rig.json");
  write_take_json();
  std::error_code error;
  std::filesystem::rename(partial_folder_, folder_, error);
  if (error)
    throw UserError(folder_.string(), "cannot be put in place: " + error.message(), "see " + partial_folder_.string());
  finished_ = true;
}

void TakeDataset::write_marker_facts(nlohmann::json& json) const {
  json["marker_energy_explained"] = {{"by_head_pose", totals_.energy.explained_by_head()},
                                     {"with_aus", totals_.energy.explained_with_aus()},
                                     {"of_the_face_by_aus", totals_.energy.face_explained_by_aus()}};
  json["residual_rms_mm"] = totals_.energy.residual_rms_mm();
  json["largest_kkt_residual"] = totals_.largest_kkt_residual;
}

void TakeDataset::write_take_json() {
  nlohmann::json json =
      options_.metadata_json.empty() ? nlohmann::json::object() : nlohmann::json::parse(options_.metadata_json);
  json["format"] = "risorius-take";
  json["version"] = 1;
  json["source"] = options_.source;
  json["rate_hz"] = rate_hz_;
  json["frames"] = totals_.frames;
  json["solved_frames"] = solved_count();
  json["lost_frames"] = totals_.lost;
  if (totals_.time_stands > 0) json["frames_whose_time_does_not_advance"] = totals_.time_stands;
  json["first_sequence"] = first_sequence_;
  json["first_capture_time_ns"] = first_capture_time_ns_;
  json["markers"] = markers_.names;
  json["aus"] = rig_.au_names();
  json["facs_edition"] = rig_.facs_edition;
  json["rig"] = {{"name", rig_.name}, {"source", rig_.source}, {"file", "rig.json"}};
  json["level"] = markers_.names.empty() ? "au" : "markers";
  json["marker_samples"] = {{"all", totals_.samples},
                            {"filled", totals_.filled},
                            {"rejected", totals_.rejected},
                            {"missing", totals_.missing}};
  if (!ended_early_.empty()) json["ended_early"] = ended_early_;
  if (!markers_.names.empty()) write_marker_facts(json);
  json["episodes"] = episodes_.size();
  AtomicFile file(partial_folder_ / "take.json");
  file.write(json.dump(1) + "\n");
  file.commit();
}

}  // namespace risorius
