// The JSON tables that are compiled into the program: how ARKit's shapes and AUs map (takes/arkit_aus.json), how real
// faces move (performer/dynamics.json), what expressions are made of (performer/expressions.json).
#pragma once

#include <string_view>

namespace risorius {

/// By the file's name without extension, such as "arkit_aus". Throws std::invalid_argument if there is none.
std::string_view shipped_json(std::string_view name);

}  // namespace risorius
