// Checks of numbers on the command line. CLI11's own Range lets NaN pass, and reads -1 as a huge unsigned number.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace risorius {

/// A number from `least` to `most`; "nan" is none.
CLI::Validator number_between(double least, double most);
/// Of a text that may also be "auto"; number_unless_auto() reads it.
CLI::Validator number_or_auto(double least, double most);
/// The same of a whole number from 1.
CLI::Validator count_or_auto(std::uint64_t most);
/// Nothing for "auto".
std::optional<double> number_unless_auto(const std::string& text);

/// A whole number from 0, such as a seed.
CLI::Validator whole_number();

}  // namespace risorius
