// The learned continuation: equation (3) of generate/continuation_features.h, its residual and standard deviation from
// a small all-MLP network (after Guo et al. 2023, "Back to MLP", but with weights shared by all AUs). It knows no face:
// AUs of any names, any strength.
// How much the residual, and each of three plain continuations, is believed is learnt online (equation (3b) of
// generate/continuation_combination.h).
//
// The standard deviation is the network's, times a factor per horizon that is learnt online so that nine of ten values
// fall within 1.645 of them (Gibbs & Candes 2021): a prediction counts once its time has passed. Other horizons than
// the network's are interpolated, beyond the last one its prediction is held.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "generate/continuation.h"
#include "generate/continuation_combination.h"
#include "generate/continuation_features.h"
#include "generate/layers.h"
#include "generate/safetensors.h"

namespace risorius {

class LearnedContinuation final : public ContinuationModel {
 public:
  /// AUs of the frames and their bounds, as many of both, at most kMaxAus. Throws UserError naming `place` if the file
  /// is no such model, std::invalid_argument for names and bounds that do not fit.
  LearnedContinuation(const Safetensors& weights, const std::string& place, const std::vector<std::string>& names,
                      std::vector<double> upper_bound);

  std::string_view name() const noexcept override { return "learned"; }
  void observe(const AuFrame& frame) noexcept override;
  void predict(Continuation& continuation) noexcept override;
  void reset() noexcept override;

 private:
  static constexpr std::size_t kHorizons = kContinuationHorizonsMs.size();
  static constexpr std::size_t kRemembered = 64;                 ///< predictions, at least 15 ms apart
  using Table = Eigen::Array<float, kHorizons, Eigen::Dynamic>;  ///< horizons x AUs
  using Terms = Eigen::Matrix<float, ContinuationCombination::kTerms, Eigen::Dynamic>;  ///< terms x AUs
  struct Prediction {
    std::int64_t time_ns = 0;
    Table mean, deviation;  ///< without the factors
    std::array<Terms, kHorizons> terms;
    Eigen::ArrayXf value, scale;  ///< then
  };

  Prediction empty() const;
  void run() noexcept;
  void remember() noexcept;
  void learn(std::int64_t time_ns, std::int64_t before_ns) noexcept;
  void score(const Prediction& made, std::size_t horizon, float share) noexcept;

  std::vector<double> upper_bound_;
  ContinuationFeatureMaker maker_;
  ContinuationFeatures features_;
  Dense<float> input_, first_, second_, output_;
  Eigen::ArrayXf hidden_, more_, out_;
  ContinuationCombination combination_;
  Prediction now_;
  std::vector<Prediction> made_;  ///< ring
  std::size_t made_next_ = 0, made_count_ = 0;
  std::array<float, kHorizons> log_factor_{};
  std::vector<float> x_, before_, least_, most_;  ///< last two frames; range since the first one
  std::vector<bool> observed_, was_observed_;
  std::int64_t time_ns_ = 0;
  bool started_ = false;
};

}  // namespace risorius
