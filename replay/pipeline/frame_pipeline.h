// The stages of one stream in the order in which data flows; the daemon and the offline tool run this same object,
// which is why live equals offline.
//
//   MarkerFrame -> [despike] -> [fill] -> [head pose + AU solve] -> SolvedFrame -> [continue] -> Continuation
//
// Thread rule: one thread. push, pop, continue_from and flush do not allocate; use_marker_set and a neutral's end do.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/frames.h"
#include "capture/marker_set.h"
#include "capture/repair/despiker.h"
#include "capture/repair/gap_filler.h"
#include "generate/continuation.h"
#include "generate/continuation_models.h"
#include "solve/au_solver.h"
#include "solve/rigs/rig.h"

namespace risorius {

/// A cleaned marker frame and the AUs solved from it.
struct SolvedFrame {
  MarkerFrame markers;
  AuFrame aus;
};

struct PipelineOptions {
  DespikerOptions despike;
  GapFillerOptions fill;
  AuSolverOptions solve;
  ContinuerOptions continuation;
  ContinuationModelOptions continuation_model;
};

/// What a frame has behind it.
enum class PipelineStep : std::uint8_t { kCleaned, kSolved };

class FramePipeline {
 public:
  /// Throws UserError where options or rig are not valid.
  FramePipeline(const PipelineOptions& options, Rig rig);

  /// A take begins or its names change: maps every stage to the names. If the rig does not fit, markers are still
  /// cleaned, every AuFrame says kNotSolved, and rig_problem() says why. Throws UserError if the set itself is not
  /// valid.
  void use_marker_set(const MarkerSet& set);
  const std::string& rig_problem() const noexcept { return rig_problem_; }

  /// False: not ready, pop first.
  /// A frame that is not of the set in use is consumed and counted as refused.
  bool push(const MarkerFrame& frame) noexcept;
  bool pop(SolvedFrame& out) noexcept;
  /// What the last frame still has to teach, off its way: called after it was handed on, or by the next push.
  void settle() noexcept {
    despiker_.settle();
    filler_.settle();
  }
  /// At the end of a take: what the stages still hold can be popped.
  void flush() noexcept;
  /// Forgets the past; for a new take of the same names.
  void reset() noexcept;

  /// Told when a frame that pop hands on has a step behind it. For the daemon, which has a clock: no stage has one, and
  /// no value depends on it.
  using StepObserver = void (*)(void* context, PipelineStep step) noexcept;
  void observe_steps(StepObserver observer, void* context) noexcept {
    observer_ = observer;
    observer_context_ = context;
  }

  /// How the face goes on after `frame`; at its own rate, so false for most frames. Called after `frame` was handed on.
  bool continue_from(const AuFrame& frame, Continuation& out) noexcept { return continuer_.process(frame, out); }

  /// From the next frame on, average the measured markers in the head frame for `duration_ns` of capture time and then
  /// put the mean in the place of the rig's neutral (the AU fields stay). A face that moves meanwhile by more than
  /// kLargestMotionMm is refused; the end of the take or another set cancels it.
  void begin_neutral_capture(std::int64_t duration_ns) noexcept;
  struct NeutralCapture {
    std::uint64_t completed = 0;  ///< how many have ended
    std::uint64_t refused = 0;    ///< how many gave no neutral: no face, or one that moved
    std::uint64_t cancelled = 0;  ///< how many the end of the take or another set ended
    std::uint32_t frames = 0;     ///< that the last one averaged
    double largest_shift_mm = 0;  ///< of a marker, last one
    double motion_mm = 0;         ///< rms of the markers about their means, last one
    bool running = false;
  };
  const NeutralCapture& neutral_capture() const noexcept { return neutral_; }

  const Counter& refused() const noexcept { return refused_; }
  const Rig& rig() const noexcept { return rig_; }
  const Despiker& despiker() const noexcept { return despiker_; }
  const GapFiller& filler() const noexcept { return filler_; }
  const AuSolver& solver() const noexcept { return solver_; }
  const Continuer& continuer() const noexcept { return continuer_; }

 private:
  void note(PipelineStep step) const noexcept {
    if (observer_ != nullptr) observer_(observer_context_, step);
  }
  void add_to_neutral(const SolvedFrame& frame);
  void finish_neutral();
  void cancel_neutral() noexcept;
  void restart_neutral() noexcept;

  Rig rig_;
  Despiker despiker_;
  GapFiller filler_;
  AuSolver solver_;
  Continuer continuer_;
  std::string rig_problem_ = "no marker set yet";
  Counter refused_;
  std::uint32_t set_id_ = 0, set_count_ = 0;
  std::vector<int> set_index_of_rig_marker_;
  MarkerFrame between_;
  StepObserver observer_ = nullptr;
  void* observer_context_ = nullptr;

  NeutralCapture neutral_;
  std::int64_t neutral_duration_ns_ = 0;
  std::optional<std::int64_t> neutral_begin_ns_;
  Eigen::Matrix3Xd neutral_sum_mm_;
  Eigen::VectorXd neutral_squares_mm2_;  // sums of squared distances from the present neutral
  Eigen::VectorXd neutral_count_;
};

}  // namespace risorius
