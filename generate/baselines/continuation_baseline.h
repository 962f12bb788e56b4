// What the simple continuations share: each AU for itself, observed frames only, values clipped to its bounds, standard
// deviations learnt from their own errors (prediction_errors.h). A derived class says how one AU goes on.
#pragma once

#include <array>
#include <vector>

#include "generate/continuation.h"
#include "generate/prediction_errors.h"

namespace risorius {

class ContinuationBaseline : public ContinuationModel {
 public:
  void observe(const AuFrame& frame) noexcept final;
  void predict(Continuation& continuation) noexcept final;
  void reset() noexcept final;

 protected:
  /// `upper_bound` per AU, 1 to kMaxAus of them, in (0, 2]. Throws std::invalid_argument.
  explicit ContinuationBaseline(std::vector<double> upper_bound, double memory_s = 10);
  std::size_t au_count() const noexcept { return upper_bound_.size(); }

  /// The AU's next observed value. `since_s` its last: 0 if there was none, or none within a quarter of a second, so
  /// that its motion begins anew.
  virtual void follow(std::size_t au, double value, double since_s) noexcept = 0;
  /// Of an AU that was followed, before it is clipped.
  virtual double predicted(std::size_t au, double ahead_s) const noexcept = 0;

 private:
  std::vector<double> upper_bound_;
  PredictionErrors errors_;
  std::vector<std::int64_t> followed_ns_;  ///< kNever: not since the reset
  std::array<float, kMaxAus> last_{};      ///< the frame's values, whatever their state
  std::array<float, kMaxAus> observed_{};  ///< the same, NaN where not observed
  bool has_frame_ = false;
};

}  // namespace risorius
