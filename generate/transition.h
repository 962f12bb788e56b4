// From the present expression to another in a given number of frames: what every generator of transitions does, a
// formula or a network.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

namespace risorius {

/// frames x AUs, one frame after the other in memory; intensities.
using AuMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct TransitionRequest {
  AuMatrix past;                 ///< P x A, P >= 1, oldest first; the last row is where the transition starts
  Eigen::VectorXf target;        ///< A; of finite intensities, as past
  Eigen::Index frames = 0;       ///< N >= 1; row k of the result is (k + 1) / rate_hz after the last row of past
  double rate_hz = 0;            ///< of past and of the result, > 0
  std::uint64_t repetition = 0;  ///< 0: the expected course; others: varied repetitions, each the same every time
};

class TransitionModel {
 public:
  virtual ~TransitionModel() = default;
  virtual std::string_view name() const noexcept = 0;
  /// Fills `result` (N x A): its last row is the target, its intensities within [0, 1.2].
  /// Throws std::invalid_argument for requests whose sizes do not fit or that are not finite.
  virtual void generate(const TransitionRequest& request, AuMatrix& result) = 0;
  /// How many frames a face would take for it; 0 if the model cannot tell. `request.frames` is not read. Throws as
  /// generate().
  virtual Eigen::Index expected_frames(const TransitionRequest&) { return 0; }
};

}  // namespace risorius
