// Which of a configuration's addresses cannot be bound together: publish, control and the sources', each against each.
#pragma once

#include "daemon/config.h"
#include "replay/pipeline/toml_fields.h"

namespace risorius {

/// Adds one problem for each address that is taken by one before it. Addresses that cannot be read are others' to tell.
void refuse_address_clashes(const Config& config, ConfigProblems& problems);

}  // namespace risorius
