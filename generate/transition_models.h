// The generators of transitions by name.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "generate/transition.h"

namespace risorius {

/// The one that is used where none is named first.
inline constexpr std::array<std::string_view, 6> kTransitionModelNames{
    "expression_generator", "minimum_jerk", "hold", "linear", "cubic_hermite", "quintic"};

/// For these AUs. Null if there is none of that name.
std::unique_ptr<TransitionModel> make_transition_model(std::string_view name, const std::vector<std::string>& au_names);

}  // namespace risorius
