// The scores of a blind comparison as a picture: a bar per comparison, with its interval.
#pragma once

#include <span>

#include "replay/picture/canvas.h"
#include "replay/study/study_score.h"

namespace risorius {

/// At least one score. Throws std::invalid_argument.
Canvas study_picture(std::span<const ComparisonScore> scores);

}  // namespace risorius
