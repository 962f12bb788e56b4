#include "daemon/recorder.h"

#include <exception>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "daemon/time_slice.h"
#include "replay/dataset/dataset_folder.h"

namespace risorius {
namespace {

constexpr std::int64_t kShortestTakeNs = 1'000'000'000;  // between two that begin because the capture time goes back

}  // namespace

Recorder::Recorder(Options options, Channel<OutputItem>& results)
    : options_(std::move(options)), results_(results), states_(options_.streams.size()) {
  begin_dataset_folder(options_.folder);
  thread_ = std::thread([this] { run(); });
}

Recorder::~Recorder() { stop(); }

void Recorder::stop() {
  stopping_ = true;
  results_.ring();
  if (thread_.joinable()) thread_.join();
}

std::string Recorder::problem() const {
  const std::scoped_lock lock(problem_mutex_);
  return problem_;
}

void Recorder::note_problem(const std::string& what) noexcept {
  const std::scoped_lock lock(problem_mutex_);
  if (problem_.empty()) problem_ = what;
}

void Recorder::run() noexcept {
  ask_for_usual_slices();
  while (true) {
    const bool last_round = stopping_;
    while (const OutputItem* item = results_.front()) {
      record(*item);
      results_.release();
    }
    if (last_round) break;
    results_.wait();
  }
  for (auto& state : states_) finish_take(state);
  if (!problem().empty()) return;  // a dataset with a manifest is complete; this one is not
  try {
    finish_dataset_folder(options_.folder, options_.card_markdown);
  } catch (const std::exception& error) {
    note_problem(error.what());
  }
}

void Recorder::record(const OutputItem& item) noexcept {
  StreamState& state = states_[item.stream_id];
  switch (item.kind) {
    case OutputItem::Kind::kMarkerSet:
      finish_take(state);  // a take has one marker set
      state.markers = item.marker_set;
      break;
    case OutputItem::Kind::kEndOfStream:
      finish_take(state);
      break;
    case OutputItem::Kind::kNeutral:
      break;  // the frames say which one they were solved with
    case OutputItem::Kind::kRecordingStarted:
    case OutputItem::Kind::kRecordingStopped:
      if (!options_.follow_tracker) break;
      finish_take(state);  // a take is one recording of the tracker
      state.tracker_records = item.kind == OutputItem::Kind::kRecordingStarted;
      state.tracker_recording.assign(item.recording_name_bytes.data(), item.recording_name_size);
      break;
    case OutputItem::Kind::kSolved:
      if (options_.follow_tracker && !state.tracker_records) {
        frames_outside_.add();
        break;
      }
      record_frame(state, item);
      break;
  }
}

void Recorder::record_frame(StreamState& state, const OutputItem& item) noexcept {
  const SolvedFrame& frame = item.solved;
  if (item.neutral != state.neutral) finish_take(state);  // a take has one neutral
  const bool fits_set = state.markers != nullptr && state.markers->names.size() == frame.markers.count;
  if (state.failed || !fits_set) {
    frames_not_written_.add();
    return;
  }
  try {
    if (state.take && begins_take(state, frame.markers)) finish_take(state);
    ++state.frames;  // first: a take that cannot be begun has lost this frame
    if (item.neutral != state.neutral) take_neutral(state, item);
    if (!state.take) begin_take(state, options_.streams[item.stream_id]);
    state.take->write(frame);
  } catch (const std::exception& error) {
    give_up_take(state, error.what());
  }
}

/// A sender whose time leaps to and fro begins at most one take a second by that; one whose time stands, none.
bool Recorder::begins_take(StreamState& state, const MarkerFrame& frame) noexcept {
  if (!state.take->continues_with(frame)) return true;
  if (!state.take->time_goes_back(frame)) return false;
  const std::int64_t now_ns = frame.header.receive_time_ns;
  if (state.went_back_ns != INT64_MIN && difference_ns(now_ns, state.went_back_ns) < kShortestTakeNs) return false;
  state.went_back_ns = now_ns;
  return true;
}

/// This thread may lag: the rig is the one that the frame was solved with, not the newest.
void Recorder::take_neutral(StreamState& state, const OutputItem& item) {
  auto stream = options_.with_neutral(item.stream_id, item.neutral);
  if (!stream) {
    throw UserError(options_.streams[item.stream_id].name,
                    fmt::format("the rig of live neutral {} is forgotten: the disk is far behind", item.neutral),
                    "take neutrals less often, or record to a faster disk");
  }
  options_.streams[item.stream_id] = *std::move(stream);
  state.neutral = item.neutral;
}

void Recorder::begin_take(StreamState& state, const Stream& stream) {
  const auto folder = options_.folder / fmt::format("{}-{:03}", stream.name, ++state.takes);
  TakeDatasetOptions options{.source = stream.name, .metadata_json = stream.metadata_json};
  if (!state.tracker_recording.empty()) {
    auto metadata = nlohmann::json::parse(stream.metadata_json);
    metadata["tracker_recording"] = state.tracker_recording;
    options.metadata_json = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  state.take = std::make_unique<TakeDataset>(folder, *state.markers, stream.rig, std::move(options));
}

void Recorder::finish_take(StreamState& state) noexcept {
  if (state.take) {
    try {
      state.take->finish();
      state.take.reset();
      frames_recorded_.add(state.frames);
      takes_finished_.add();
    } catch (const std::exception& error) {
      give_up_take(state, error.what());
    }
  }
  state.frames = 0;
  state.failed = false;  // the next take may find the disk in better health
}

/// What the disk took before it refused becomes a take of its own right; the rest is not written.
void Recorder::give_up_take(StreamState& state, const std::string& why) noexcept {
  note_problem(why);
  std::uint64_t kept = 0;
  try {
    if (state.take) {
      state.take->finish_early(why);
      kept = state.take->frame_count() - state.take->lost_count();
      takes_finished_.add();
    }
  } catch (const std::exception&) {
    kept = 0;  // `why` says it
  }
  frames_recorded_.add(kept);
  frames_not_written_.add(state.frames - kept);
  state.frames = 0;
  state.take.reset();
  state.failed = true;
}

}  // namespace risorius
