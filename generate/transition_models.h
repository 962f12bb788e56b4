// The generators of transitions by name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "generate/transition.h"

namespace risorius {

/// The one that is used where none is named first.
std::vector<std::string_view> transition_model_names();

/// For these AUs. Null if there is none of that name.
std::unique_ptr<TransitionModel> make_transition_model(std::string_view name, const std::vector<std::string>& au_names);

}  // namespace risorius
