// What the models that learn from a stream of frames have in common.
#pragma once

#include <cmath>
#include <fmt/format.h>

#include "capture/errors.h"

namespace risorius {

/// A leap of the tracker's clock must not make a model forget everything.
inline constexpr double kLongestForgottenS = 1.0;

/// The option's value, finite and > 0. Throws UserError naming it.
inline double require_positive(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return value;
  throw UserError(name, fmt::format("{} is not a positive number", value), "leave it out for the default");
}

}  // namespace risorius
