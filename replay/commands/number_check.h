// Checks of numbers on the command line. CLI11's own Range lets NaN pass, and reads -1 as a huge unsigned number.
#pragma once

#include <CLI/CLI.hpp>

namespace risorius {

/// A number from `least` to `most`; "nan" is none.
CLI::Validator number_between(double least, double most);

/// A whole number from 0, such as a seed.
CLI::Validator whole_number();

}  // namespace risorius
