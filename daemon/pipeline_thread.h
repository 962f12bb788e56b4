// The one thread that repairs and solves. It takes admitted items in their order, runs each stream's stages, hands
// every solved frame to publisher and recorder, and only then asks for the continuation. It sleeps when there is
// nothing to do. After warm-up it allocates nothing per frame.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "daemon/channel.h"
#include "daemon/pipeline_items.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/pipeline/shape_mapper.h"

namespace risorius {

/// What the work on one frame or set took, from the moment it was taken up. A cycle is all of it, learning included;
/// its budget is the time between two frames.
struct CycleCounters {
  Counter longest_clean_ns, longest_solve_ns, longest_cycle_ns;
  Counter over_budget;
};

/// One stream's stages and what the status says of them. Counters are written by the pipeline thread alone.
struct PipelineStream {
  /// `shape_table`: null for a stream of markers; of a stream of face shapes how they become the rig's AUs.
  PipelineStream(const PipelineOptions& options, Rig rig, const ArkitTable* shape_table = nullptr);
  FramePipeline stages;
  std::unique_ptr<ShapeMapper> shapes;  ///< in the place of repair and solve; null for a stream of markers
  /// Why the rig does not fit the current marker set; empty if it does. For the status, from any thread.
  std::string rig_problem() const {
    const std::scoped_lock lock(mutex_);
    return rig_problem_;
  }
  /// Which of the rig's markers the current marker set lacks; empty if none.
  std::string absent_markers() const {
    const std::scoped_lock lock(mutex_);
    return absent_markers_;
  }
  void note_fit_of_rig(const MarkerSet& set) {
    const std::scoped_lock lock(mutex_);
    rig_problem_ = stages.rig_problem();
    absent_markers_ = rig_problem_.empty() ? describe_absent_markers(stages.rig(), set) : "";
  }
  Counter processed;                                  ///< frames handed on
  std::array<Counter, kSolverStatusCount> by_status;  ///< of these, by SolverStatus
  CycleCounters cycles;
  std::int64_t budget_ns = 0;  ///< of a cycle; 0: the set states no rate. The pipeline thread's own
  Counter continuations;
  Counter neutral_captures;  ///< completed
  Counter neutral_failures;  ///< refused or cancelled

  /// What frames are solved with from one live neutral to the next.
  struct Actor {
    std::uint64_t neutral = 0;  ///< how many were taken before
    Rig rig;
    std::array<double, kFaceShapes> shape_neutral{};  ///< taken off the face shapes; all 0 for a stream of markers
  };
  /// As it is now. From any thread.
  std::shared_ptr<const Actor> actor() const {
    const std::scoped_lock lock(mutex_);
    return actors_.back();
  }
  /// As it was after so many neutrals, for whoever lags behind; null if that is kActorsKept neutrals ago. From any
  /// thread.
  std::shared_ptr<const Actor> actor_of(std::uint64_t neutral) const;
  void note_actor(std::uint64_t neutral);

 private:
  mutable std::mutex mutex_;  // taken when a set or a neutral begins and for a status, never per frame
  std::string rig_problem_, absent_markers_;
  static constexpr std::size_t kActorsKept = 256;
  std::deque<std::shared_ptr<const Actor>> actors_;  ///< the latest, oldest first
};

class PipelineThread {
 public:
  struct Outputs {
    Channel<OutputItem>& publish;          ///< full: the frame is not published, counted by the channel
    Channel<Continuation>& continuations;  ///< full: not published, counted by the channel
    Channel<OutputItem>* record;           ///< null if nothing is recorded; full: not recorded, counted by the channel
  };
  /// Reads how many allocations the calling thread has made; null in production, set by tests.
  using AllocationProbe = std::uint64_t (*)() noexcept;

  PipelineThread(Channel<AdmittedItem>& admitted, std::deque<PipelineStream>& streams, const Outputs& outputs,
                 AllocationProbe allocation_probe = nullptr);
  ~PipelineThread();
  PipelineThread(const PipelineThread&) = delete;
  PipelineThread& operator=(const PipelineThread&) = delete;

  /// Works off what is admitted, then ends the thread.
  void stop();

  /// While working on frames (not on sets and controls), if there is a probe.
  std::uint64_t allocations_in_frames() const noexcept { return allocations_in_frames_.value(); }

 private:
  void run() noexcept;
  void work_on(const AdmittedItem& item);
  void work_on_frame(PipelineStream& stream, const AdmittedItem& item) noexcept;
  void note_cycle(PipelineStream& stream) const noexcept;
  void map_shapes(PipelineStream& stream, const AdmittedItem& item) noexcept;
  void hand_on_solved(PipelineStream& stream, std::uint32_t stream_id) noexcept;
  void hand_on_frame(PipelineStream& stream, std::uint32_t stream_id) noexcept;
  static void note_neutral_failures(PipelineStream& stream) noexcept;
  void hand_on_control(OutputItem::Kind kind, std::uint32_t stream_id, const MarkerSet* marker_set) noexcept;
  static void note_step(void* self, PipelineStep step) noexcept;

  Channel<AdmittedItem>& admitted_;
  std::deque<PipelineStream>& streams_;
  Outputs outputs_;
  AllocationProbe allocation_probe_;
  std::int64_t begun_ns_ = 0;  ///< the frame at work
  OutputItem out_;
  Continuation continuation_;
  Counter allocations_in_frames_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace risorius
