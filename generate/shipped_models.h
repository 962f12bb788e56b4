// The trained models that are compiled in (generate/weights/*.safetensors): performer and alex_rom_3 only, see their
// metadata.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "generate/continuation.h"
#include "generate/transition.h"

namespace risorius {

/// `names` are the AUs of the requests, any. The default: "expression_generator".
std::unique_ptr<TransitionModel> shipped_expression_generator(const std::vector<std::string>& names);

/// What it was trained on: its weights' metadata, with the names of recordings as files ("alex_rom_3.csv").
std::string shipped_expression_generator_trained_on();

/// `names` and `upper_bound` of the frames' AUs, as many of both. Named "learned".
std::unique_ptr<ContinuationModel> shipped_continuation(const std::vector<std::string>& names,
                                                        std::vector<double> upper_bound);

}  // namespace risorius
