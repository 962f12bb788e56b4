// The two ends of a transition as users name them: an expression of the performer ("happy", "sad:2") or an AU series
// ("take.csv": of the start its last frame, of the end its first; "take.csv:120": that frame).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "generate/transition.h"

namespace risorius {

struct TransitionEnds {
  std::vector<std::string> names;  ///< AUs: of the start's file, else of the end's, else `default_names`
  AuMatrix past;  ///< rows x AUs up to the start at the course's rate, at most `most_past_frames`; one of an expression
  Eigen::VectorXf target;
  std::vector<std::string> notes;  ///< what one end has and the other not, and what was not observed (0)
};

struct TransitionEndOptions {
  double rate_hz = 120;                ///< of the course, > 0
  std::optional<double> from_rate_hz;  ///< of the start's file; else what its timecodes say, else `rate_hz`
  Eigen::Index most_past_frames = 20;
};

/// The file of an end: "take.csv" of "take.csv" and of "take.csv:120"; empty for an expression.
std::string file_of_end(const std::string& end);

/// `default_names`: where neither end is a file. Throws UserError.
TransitionEnds transition_ends(const std::string& from, const std::string& to,
                               const std::vector<std::string>& default_names, const TransitionEndOptions& options = {});

}  // namespace risorius
