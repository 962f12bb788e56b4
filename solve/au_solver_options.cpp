#include "solve/au_solver_options.h"

#include <fmt/format.h>
#include <stdexcept>

namespace risorius {
namespace {

template <class T>
void require(const char* name, T value, bool inside, const char* range) {
  if (!inside) throw std::invalid_argument(fmt::format("AuSolverOptions.{} {} is not in {}", name, value, range));
}

}  // namespace

void validate(const AuSolverOptions& o) {
  require("noise_mm", o.noise_mm, o.noise_mm > 0 && o.noise_mm <= 10, "(0, 10]");
  require("ridge", o.ridge, o.ridge >= 1e-9 && o.ridge <= 1, "[1e-9, 1]");
  require("temporal", o.temporal, o.temporal >= 0 && o.temporal <= 1000, "[0, 1000]");
  require("temporal_speed", o.temporal_speed, o.temporal_speed > 0 && o.temporal_speed <= 1000, "(0, 1000]");
  require("l1", o.l1, o.l1 >= 0 && o.l1 <= 1000, "[0, 1000]");
  require("left_right", o.left_right, o.left_right >= 0 && o.left_right <= 1000, "[0, 1000]");
  require("robust_threshold_mm", o.robust_threshold_mm, o.robust_threshold_mm > 0 && o.robust_threshold_mm <= 1000,
          "(0, 1000]");
  require("robust_iterations", o.robust_iterations, o.robust_iterations >= 0 && o.robust_iterations <= 20, "0 to 20");
  require("min_visible_share", o.min_visible_share, o.min_visible_share > 0 && o.min_visible_share <= 1, "(0, 1]");
  require("largest_median_mm", o.largest_median_mm, o.largest_median_mm > 0 && o.largest_median_mm <= 1000,
          "(0, 1000]");
  require("pose_steps", o.pose_steps, o.pose_steps >= 0 && o.pose_steps <= 20, "0 to 20");
}

}  // namespace risorius
