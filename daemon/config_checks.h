// What the values of a configuration must be beyond their type and range: each alone, and together.
#pragma once

#include "daemon/config.h"
#include "replay/pipeline/toml_fields.h"

namespace risorius {

/// Adds each problem with its key, value and remedy.
void check_config(const Config& config, ConfigProblems& problems);

}  // namespace risorius
