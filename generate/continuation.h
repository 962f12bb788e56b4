// How the face goes on: a ContinuationModel sees AU frames and predicts AU vectors at given times ahead; a Continuer
// decides which frames it sees and when a prediction is due (at most so many per second of capture time).
//
// AUs that are not observed stay not observed: their standard deviation is NaN, their intensity the last value of the
// frame. All other entries are finite. Runs after the frame is published, so virtual calls are allowed; nothing
// allocates after construction. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "capture/frames.h"

namespace risorius {

class ContinuationModel {
 public:
  virtual ~ContinuationModel() = default;
  virtual std::string_view name() const noexcept = 0;
  /// The next frame, later than the last. Solved frames only.
  virtual void observe(const AuFrame& frame) noexcept = 0;
  /// Fills intensity and standard_deviation of continuation's steps, whose count, AU count and ahead_ns are set; from
  /// the frame observed last.
  virtual void predict(Continuation& continuation) noexcept = 0;
  /// Forgets the face's motion (not what was learnt about errors): time went back, or the take ended.
  virtual void reset() noexcept = 0;
};

struct ContinuerOptions {
  double max_rate_hz = 60;                                     ///< [1, 1000], of capture time
  std::vector<double> horizons_ms = {50, 100, 150, 250, 500};  ///< 1 to 32, ascending, (0, 2000]
};

class Continuer {
 public:
  /// Throws std::invalid_argument for options out of range or no model.
  Continuer(std::unique_ptr<ContinuationModel> model, const ContinuerOptions& options = {});

  /// True if a prediction was due and written. Frames that were not solved, or that come sooner than the rate allows,
  /// are not shown to the model; a frame of another AU set or an earlier time resets it.
  bool process(const AuFrame& frame, Continuation& continuation) noexcept;

  const ContinuationModel& model() const noexcept { return *model_; }

 private:
  bool is_due(const AuFrame& frame) noexcept;

  std::unique_ptr<ContinuationModel> model_;
  std::int64_t interval_ns_;
  std::vector<std::int64_t> ahead_ns_;
  bool started_ = false;
  std::uint32_t set_id_ = 0;
  std::int64_t last_time_ns_ = 0;  // of the last frame seen
  std::int64_t due_ns_ = 0;
};

}  // namespace risorius
