#include "daemon/pipeline_thread.h"

#include <algorithm>

#include "capture/check.h"
#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {

PipelineStream::PipelineStream(const PipelineOptions& options, Rig rig, const ArkitTable* shape_table)
    : stages(options, std::move(rig)) {
  if (shape_table != nullptr) shapes = std::make_unique<ShapeMapper>(*shape_table, stages.rig());
  note_actor(0);
}

std::shared_ptr<const PipelineStream::Actor> PipelineStream::actor_of(std::uint64_t neutral) const {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(actors_, neutral, [](const auto& actor) { return actor->neutral; });
  return found == actors_.end() ? nullptr : *found;
}

void PipelineStream::note_actor(std::uint64_t neutral) {
  auto actor = std::make_shared<Actor>(Actor{.neutral = neutral, .rig = stages.rig(), .shape_neutral = {}});
  if (shapes) actor->shape_neutral = shapes->neutral();
  const std::scoped_lock lock(mutex_);
  actors_.push_back(std::move(actor));
  if (actors_.size() > kActorsKept) actors_.pop_front();
}

PipelineThread::PipelineThread(Channel<AdmittedItem>& admitted, std::deque<PipelineStream>& streams,
                               const Outputs& outputs, AllocationProbe allocation_probe)
    : admitted_(admitted), streams_(streams), outputs_(outputs), allocation_probe_(allocation_probe) {
  for (PipelineStream& stream : streams_) stream.stages.observe_steps(&PipelineThread::note_step, this);
  thread_ = std::thread([this] { run(); });
}

void PipelineThread::note_step(void* self, PipelineStep step) noexcept {
  OutputItem& out = static_cast<PipelineThread*>(self)->out_;
  (step == PipelineStep::kCleaned ? out.cleaned_ns : out.solved_ns) = monotonic_now_ns();
}

PipelineThread::~PipelineThread() { stop(); }

void PipelineThread::stop() {
  stopping_ = true;
  admitted_.ring();
  if (thread_.joinable()) thread_.join();
}

void PipelineThread::run() noexcept {
  while (true) {
    // Read before the queue is emptied: whatever was admitted before the stop is still worked off.
    const bool last_round = stopping_;
    // Only for the first frame after a rest: while frames queue up, the publisher is awake, and throughput counts.
    if (const AdmittedItem* item = admitted_.front(); item != nullptr && item->kind == AdmittedItem::Kind::kFrame)
      outputs_.publish.announce();
    while (const AdmittedItem* item = admitted_.front()) {
      work_on(*item);
      admitted_.release();
    }
    if (last_round) return;
    admitted_.wait();
  }
}

void PipelineThread::work_on(const AdmittedItem& item) {
  PipelineStream& stream = streams_[item.stream_id];
  switch (item.kind) {
    case AdmittedItem::Kind::kFrame:
    case AdmittedItem::Kind::kShapes: {
      const std::uint64_t before = allocation_probe_ ? allocation_probe_() : 0;
      work_on_frame(stream, item);
      if (allocation_probe_) allocations_in_frames_.add(allocation_probe_() - before);
      break;
    }
    case AdmittedItem::Kind::kMarkerSet:
      begun_ns_ = monotonic_now_ns();
      stream.stages.flush();
      hand_on_solved(stream, item.stream_id);
      if (!stream.shapes) {
        try {
          stream.stages.use_marker_set(*item.marker_set);
        } catch (const UserError&) {
          // Every source asks problems_of. Should one forget it, its frames are refused and counted, and the others go
          // on.
          break;
        }
        stream.note_fit_of_rig(*item.marker_set);
        note_neutral_failures(stream);
      }
      stream.budget_ns = item.marker_set->rate_hz > 0 ? static_cast<std::int64_t>(1e9 / item.marker_set->rate_hz) : 0;
      hand_on_control(OutputItem::Kind::kMarkerSet, item.stream_id, item.marker_set);
      note_cycle(stream);
      break;
    case AdmittedItem::Kind::kEndOfStream:
      stream.stages.flush();
      hand_on_solved(stream, item.stream_id);
      stream.stages.reset();
      if (stream.shapes) stream.shapes->reset();
      note_neutral_failures(stream);
      hand_on_control(OutputItem::Kind::kEndOfStream, item.stream_id, nullptr);
      break;
    case AdmittedItem::Kind::kNeutralCapture:
      if (stream.shapes) {
        stream.shapes->begin_neutral_capture(item.duration_ns);
      } else {
        stream.stages.begin_neutral_capture(item.duration_ns);
      }
      note_neutral_failures(stream);
      break;
    case AdmittedItem::Kind::kRecordingStarted:
    case AdmittedItem::Kind::kRecordingStopped:
      out_.recording_name_size = item.recording_name_size;
      out_.recording_name_bytes = item.recording_name_bytes;
      hand_on_control(item.kind == AdmittedItem::Kind::kRecordingStarted ? OutputItem::Kind::kRecordingStarted
                                                                         : OutputItem::Kind::kRecordingStopped,
                      item.stream_id, nullptr);
      break;
  }
}

void PipelineThread::work_on_frame(PipelineStream& stream, const AdmittedItem& item) noexcept {
  begun_ns_ = monotonic_now_ns();
  if (item.kind == AdmittedItem::Kind::kShapes) {
    map_shapes(stream, item);
  } else {
    while (!stream.stages.push(item.frame)) hand_on_solved(stream, item.stream_id);
    hand_on_solved(stream, item.stream_id);
    stream.stages.settle();
  }
  note_cycle(stream);
}

void PipelineThread::note_cycle(PipelineStream& stream) const noexcept {
  const std::int64_t cycle_ns = monotonic_now_ns() - begun_ns_;
  stream.cycles.longest_cycle_ns.raise_to(static_cast<std::uint64_t>(cycle_ns));
  if (stream.budget_ns > 0 && cycle_ns > stream.budget_ns) stream.cycles.over_budget.add();
}

/// Enters where others leave the solve.
void PipelineThread::map_shapes(PipelineStream& stream, const AdmittedItem& item) noexcept {
  RISORIUS_CHECK(stream.shapes != nullptr);
  out_.solved.markers.header = item.shapes.header;
  out_.solved.markers.count = 0;
  out_.cleaned_ns = begun_ns_;
  stream.shapes->process(item.shapes, out_.solved.aus);
  out_.solved_ns = monotonic_now_ns();
  hand_on_frame(stream, item.stream_id);
}

void PipelineThread::hand_on_solved(PipelineStream& stream, std::uint32_t stream_id) noexcept {
  while (stream.stages.pop(out_.solved)) hand_on_frame(stream, stream_id);
}

void PipelineThread::hand_on_frame(PipelineStream& stream, std::uint32_t stream_id) noexcept {
  out_.kind = OutputItem::Kind::kSolved;
  out_.stream_id = stream_id;
  out_.neutral = stream.neutral_captures.value();
  stream.processed.add();
  stream.by_status[static_cast<std::size_t>(out_.solved.aus.status)].add();
  stream.cycles.longest_clean_ns.raise_to(static_cast<std::uint64_t>(out_.cleaned_ns - begun_ns_));
  stream.cycles.longest_solve_ns.raise_to(static_cast<std::uint64_t>(out_.solved_ns - out_.cleaned_ns));
  outputs_.publish.send_frame(out_);
  if (outputs_.record != nullptr) outputs_.record->send_frame(out_);
  const std::uint64_t neutrals =
      stream.shapes ? stream.shapes->neutrals_completed() : stream.stages.neutral_capture().completed;
  if (neutrals != stream.neutral_captures.value()) {
    stream.note_actor(neutrals);
    stream.neutral_captures.set(neutrals);
    hand_on_control(OutputItem::Kind::kNeutral, stream_id, nullptr);
    out_.kind = OutputItem::Kind::kSolved;
  }
  note_neutral_failures(stream);
  // After the frame is on its way: a prediction never delays a measurement.
  if (stream.stages.continue_from(out_.solved.aus, continuation_)) {
    stream.continuations.add();
    if (outputs_.continuations.send_frame(continuation_)) outputs_.publish.ring();
  }
}

void PipelineThread::note_neutral_failures(PipelineStream& stream) noexcept {
  const FramePipeline::NeutralCapture& neutral = stream.stages.neutral_capture();
  stream.neutral_failures.set(stream.shapes ? stream.shapes->neutrals_cancelled()
                                            : neutral.refused + neutral.cancelled);
}

void PipelineThread::hand_on_control(OutputItem::Kind kind, std::uint32_t stream_id,
                                     const MarkerSet* marker_set) noexcept {
  out_.kind = kind;
  out_.stream_id = stream_id;
  out_.marker_set = marker_set;
  outputs_.publish.send_control(out_);
  if (outputs_.record != nullptr) outputs_.record->send_control(out_);
}

}  // namespace risorius
