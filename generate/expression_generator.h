// The default Expression-Generator: the curve of generate/transition_features.h, equation (2), whose residual comes
// from one small network that all AUs share, so that it works for any set of AUs and knows nothing of one person's
// face.
//
//   past -> LSTM (encoder) -> tanh(linear) -> state of an LSTM (decoder), which runs over the spline's knots -> r
//
// Several such members are trained alike but for what they begin with and are shown. Repetition 0 is the expected
// course: their mean, without noise. Another repetition is one member's, with a drawn noise input of the decoder, the
// same for all AUs of the transition. Holds scratch: one thread per object.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "generate/safetensors.h"
#include "generate/transition.h"

namespace risorius {

class ExpressionGenerator final : public TransitionModel {
 public:
  /// `names` are the AUs of the requests, any. Throws UserError naming `place` if the file is no model of this kind.
  ExpressionGenerator(const Safetensors& weights, const std::string& place, const std::vector<std::string>& names);
  ~ExpressionGenerator() override;

  std::string_view name() const noexcept override { return "expression_generator"; }
  void generate(const TransitionRequest& request, AuMatrix& result) override;
  /// 41 to 402 at 120 Hz.
  Eigen::Index expected_frames(const TransitionRequest& request) override;

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

}  // namespace risorius
