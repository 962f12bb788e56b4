// Courses of one transition over each other: a panel per AU that moves most, a line per course; their
// names above the panels.
#pragma once

#include <string>
#include <vector>

#include "generate/transition.h"
#include "replay/picture/canvas.h"

namespace risorius {

struct TransitionCourse {
  std::string label;
  AuMatrix rows;              ///< N x AUs, after the past's last row
  bool is_reference = false;  ///< drawn black and thick
};

/// At most `most_panels` AUs, those that move most in any course, two panels a row, both sides of one after each other.
/// Throws std::invalid_argument for sizes that do not fit.
Canvas transition_picture(const std::string& title, const std::vector<std::string>& names, const AuMatrix& past,
                          const std::vector<TransitionCourse>& courses, double rate_hz, std::size_t most_panels = 8);

}  // namespace risorius
