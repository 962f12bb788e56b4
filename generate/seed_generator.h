// Seed 003's Expression-Generator as a TransitionModel: the named baseline `seed`. It generates at its own rate and for
// its own AUs, which stand in the weights' metadata; requests are mapped by name and resampled. AUs that it does not
// know are masked: they follow the minimum-jerk curve. As in the thesis nothing ties its last frame to the target;
// values are only cut to [0, 1.2]. Holds scratch: one thread per object.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "generate/safetensors.h"
#include "generate/transition.h"

namespace risorius {

/// kReinterpolated: the first five generated frames are replaced by a straight line from the last frame of the past to
/// the sixth, the cure of its section 7.3 (1).
enum class SeedCure : std::uint8_t { kNone, kReinterpolated };

class SeedGenerator final : public TransitionModel {
 public:
  /// `names` are the AUs of the requests. bf16 tensors are kept as bf16 if `as_bf16`, and widened otherwise. Throws
  /// UserError naming `place` if the file is no model of this kind.
  SeedGenerator(const Safetensors& weights, const std::string& place, const std::vector<std::string>& names,
                SeedCure cure = SeedCure::kNone, bool as_bf16 = false);
  ~SeedGenerator() override;

  std::string_view name() const noexcept override;
  void generate(const TransitionRequest& request, AuMatrix& result) override;
  /// AUs of the requests that the model does not know.
  const std::vector<std::string>& masked() const noexcept;

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

}  // namespace risorius
