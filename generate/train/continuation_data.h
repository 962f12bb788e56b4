// Moments of faces in motion and what came after them, as tensors: one row per moment and AU.
#pragma once

#include <cstdint>
#include <torch/torch.h>
#include <vector>

#include "replay/corpus/au_recording.h"

namespace risorius {

struct ContinuationTensors {
  torch::Tensor inputs;  ///< R x kContinuationWidth
  torch::Tensor damped;  ///< R x horizons: damped velocity's prediction, less the value
  torch::Tensor scale;   ///< R
  torch::Tensor change;  ///< R x horizons: the truth, less the value as it was seen
  torch::Tensor value;   ///< R: as it was seen
  std::int64_t rows() const { return scale.size(0); }
};

/// How one pass over a recording differs from what was recorded.
struct ContinuationPass {
  double speed = 1;       ///< the recorded frames are taken to be so much faster
  double strength = 1;    ///< of all intensities
  double noise = 0;       ///< standard deviation of what is added to what the model sees
  std::int64_t skip = 1;  ///< every so many frames are seen
  std::uint64_t seed = 1;
};

enum class MomentPart : std::uint8_t { kAll, kTrain, kHeldOut };

/// Moments at the recording's own frames; the truth is linear between them. A take is divided into blocks of 10 s; of
/// every five the third and the fifth are held out, with what reaches into them. An AU that does not move gives one row
/// in ten.
class ContinuationDataMaker {
 public:
  void add(const AuRecording& recording, const ContinuationPass& pass, MomentPart part);
  ContinuationTensors tensors() const;

 private:
  std::vector<float> inputs_, damped_, scale_, change_, value_;
};

}  // namespace risorius
