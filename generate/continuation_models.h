// The continuations by name: what the configuration chooses from and the benches compare.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "generate/continuation.h"
#include "generate/damped_velocity.h"

namespace risorius {

enum class ContinuationKind : std::uint8_t {
  kHold,
  kDampedVelocity,
  kDoubleExponential,
  kKalman,
  kLinearAutoregression,
  kLearned
};

struct ContinuationKindEntry {
  std::string_view name;
  ContinuationKind kind;
};
inline constexpr std::array kContinuationKinds{
    ContinuationKindEntry{"hold", ContinuationKind::kHold},
    ContinuationKindEntry{"damped_velocity", ContinuationKind::kDampedVelocity},
    ContinuationKindEntry{"double_exponential", ContinuationKind::kDoubleExponential},
    ContinuationKindEntry{"kalman", ContinuationKind::kKalman},
    ContinuationKindEntry{"linear_autoregression", ContinuationKind::kLinearAutoregression},
    ContinuationKindEntry{"learned", ContinuationKind::kLearned}};

struct ContinuationModelOptions {
  ContinuationKind kind = ContinuationKind::kLearned;
  DampedVelocityOptions damped_velocity;
};

/// Of the AUs `names` with these upper bounds. Throws std::invalid_argument for options out of range.
std::unique_ptr<ContinuationModel> make_continuation_model(const ContinuationModelOptions& options,
                                                           const std::vector<std::string>& names,
                                                           const std::vector<double>& upper_bounds);

}  // namespace risorius
