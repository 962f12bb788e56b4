#include "daemon/recorder.h"

#include <exception>
#include <fmt/format.h>

#include "capture/errors.h"
#include "replay/dataset_folder.h"

namespace risorius {

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
  failed_ = true;
}

void Recorder::run() noexcept {
  while (true) {
    const bool last_round = stopping_;
    while (const OutputItem* item = results_.front()) {
      try {
        record(*item);
      } catch (const std::exception& error) {
        note_problem(error.what());
        frames_not_written_.add(item->kind == OutputItem::Kind::kSolved ? 1 : 0);
      }
      results_.release();
    }
    if (last_round) break;
    results_.wait();
  }
  try {
    for (auto& state : states_) finish_take(state);
    finish_dataset_folder(options_.folder, options_.card_markdown);
  } catch (const std::exception& error) {
    note_problem(error.what());
  }
}

void Recorder::record(const OutputItem& item) {
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
      finish_take(state);  // a take has one neutral
      options_.streams[item.stream_id].rig = options_.current_rig(item.stream_id);
      break;
    case OutputItem::Kind::kSolved:
      if (failed_) {
        frames_not_written_.add();
        break;
      }
      if (state.take && !state.take->continues_with(item.solved.markers)) finish_take(state);
      if (!state.take) begin_take(state, options_.streams[item.stream_id]);
      state.take->write(item.solved);
      frames_recorded_.add();
      break;
  }
}

void Recorder::begin_take(StreamState& state, const Stream& stream) {
  const auto folder = options_.folder / fmt::format("{}-{:03}", stream.name, ++state.takes);
  state.take =
      std::make_unique<TakeDataset>(folder, *state.markers, stream.rig,
                                    TakeDatasetOptions{.source = stream.name, .metadata_json = stream.metadata_json});
}

void Recorder::finish_take(StreamState& state) {
  if (!state.take) return;
  const auto take = std::move(state.take);
  take->finish();
  takes_finished_.add();
}

}  // namespace risorius
