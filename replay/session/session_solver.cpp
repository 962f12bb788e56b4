#include "replay/session/session_solver.h"

#include <utility>

#include "capture/errors.h"

namespace risorius {

SessionSolver::SessionSolver(const PipelineOptions& options, Rig rig, const ArkitTable* shape_table, Sink sink)
    : stages_(options, std::move(rig)), sink_(std::move(sink)) {
  if (shape_table != nullptr) shapes_ = std::make_unique<ShapeMapper>(*shape_table, stages_.rig());
}

void SessionSolver::take(const SessionTick& tick) {
  switch (tick.kind) {
    case TickKind::kFrame:
      while (!stages_.push(tick.frame)) hand_on_solved();
      hand_on_solved();
      stages_.settle();
      break;
    case TickKind::kShapes:
      if (!shapes_) throw UserError("Ticks", "face shapes in a stream of markers", "the file does not fit together");
      solved_.markers.header = tick.shapes.header;
      solved_.markers.count = 0;
      shapes_->process(tick.shapes, solved_.aus);
      hand_on_frame();
      break;
    case TickKind::kMarkerSet:
      stages_.flush();
      hand_on_solved();
      if (!shapes_) stages_.use_marker_set(tick.set);
      break;
    case TickKind::kEndOfStream:
      stages_.flush();
      hand_on_solved();
      stages_.reset();
      if (shapes_) shapes_->reset();
      break;
    case TickKind::kNeutralCapture:
      if (shapes_) {
        shapes_->begin_neutral_capture(tick.duration_ns);
      } else {
        stages_.begin_neutral_capture(tick.duration_ns);
      }
      break;
    case TickKind::kRecordingStarted:
    case TickKind::kRecordingStopped:
      break;  // says nothing to the stages
  }
}

void SessionSolver::hand_on_solved() {
  while (stages_.pop(solved_)) hand_on_frame();
}

void SessionSolver::hand_on_frame() {
  sink_.solved(solved_);
  if (stages_.continue_from(solved_.aus, continuation_)) sink_.continued(continuation_);
}

}  // namespace risorius
