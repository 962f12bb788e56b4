// What the shipped weights are trained on: the synthetic performer, and alex_rom_3 (a range of motion recorded by
// A. Djulin, MIT licence). Nothing else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "replay/corpus/transition_corpus.h"

namespace risorius {

/// Named in the weights' metadata.
inline constexpr const char* kTrainingCredit =
    "synthetic performer of Risorius; alex_rom_3.csv, Live Link Face range of motion by A. Djulin (MIT)";

struct TrainingCorpora {
  std::vector<std::string> names;
  TransitionCorpus recorded;     ///< empty without a recording
  TransitionCorpus expressions;  ///< performed
  TransitionCorpus motions;      ///< cut out of performed ranges of motion, as the recorded ones are
};

/// `recording` as load_au_recording reads it.
TrainingCorpora make_training_corpora(const std::optional<std::filesystem::path>& recording, std::uint64_t seed);

/// The training parts, and drawn variations of them until there are `count`: a share of `recorded_share` of recorded
/// ones (0 where there are none), the rest performed.
std::vector<Transition> make_training_pool(const TrainingCorpora& corpora, std::size_t count, double recorded_share,
                                           std::uint64_t seed);

}  // namespace risorius
