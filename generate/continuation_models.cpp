#include "generate/continuation_models.h"

#include <algorithm>
#include <stdexcept>

#include "generate/baselines/double_exponential.h"
#include "generate/baselines/hold.h"
#include "generate/baselines/kalman_velocity.h"
#include "generate/baselines/linear_autoregression.h"
#include "generate/shipped_models.h"

namespace risorius {

std::unique_ptr<ContinuationModel> make_continuation_model(const ContinuationModelOptions& options,
                                                           const std::vector<std::string>& names,
                                                           const std::vector<double>& upper_bounds) {
  if (names.size() != upper_bounds.size())
    throw std::invalid_argument("make_continuation_model: not as many names as upper bounds");
  const bool has_bounds = std::ranges::all_of(upper_bounds, [](double bound) { return bound > 0 && bound <= 2; });
  if (upper_bounds.empty() || !has_bounds)
    throw std::invalid_argument("make_continuation_model: upper bounds must be in (0, 2], one at least");
  switch (options.kind) {
    case ContinuationKind::kHold:
      return std::make_unique<Hold>(upper_bounds);
    case ContinuationKind::kDampedVelocity:
      return std::make_unique<DampedVelocity>(upper_bounds, options.damped_velocity);
    case ContinuationKind::kDoubleExponential:
      return std::make_unique<DoubleExponential>(upper_bounds);
    case ContinuationKind::kKalman:
      return std::make_unique<KalmanVelocity>(upper_bounds);
    case ContinuationKind::kLinearAutoregression:
      return std::make_unique<LinearAutoregression>(upper_bounds);
    case ContinuationKind::kLearned:
      return shipped_continuation(names, upper_bounds);
  }
  throw std::invalid_argument("make_continuation_model: no such kind");
}

}  // namespace risorius
