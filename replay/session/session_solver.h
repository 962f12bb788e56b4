// A stream's recorded Ticks through the stages again, step by step as the daemon's pipeline thread does it
// (daemon/pipeline_thread.cpp): the same AUs and continuations come out, bit for bit.
#pragma once

#include <functional>
#include <memory>

#include "replay/pipeline/frame_pipeline.h"
#include "replay/pipeline/shape_mapper.h"
#include "replay/session/tick_codec.h"

namespace risorius {

class SessionSolver {
 public:
  struct Sink {
    std::function<void(const SolvedFrame&)> solved;
    std::function<void(const Continuation&)> continued;  ///< after the frame that it continues
  };

  /// `shape_table`: of a stream of face shapes; null for markers. Throws UserError.
  SessionSolver(const PipelineOptions& options, Rig rig, const ArkitTable* shape_table, Sink sink);

  /// Throws UserError if the Tick is not of such a stream.
  void take(const SessionTick& tick);

  const FramePipeline& stages() const noexcept { return stages_; }

 private:
  void hand_on_solved();
  void hand_on_frame();

  FramePipeline stages_;
  std::unique_ptr<ShapeMapper> shapes_;
  Sink sink_;
  SolvedFrame solved_;
  Continuation continuation_;
};

}  // namespace risorius
