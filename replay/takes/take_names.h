// Names out of old programs' files.
#pragma once

#include <string>
#include <string_view>

#include "replay/takes/take.h"

namespace risorius {

/// The marker's name as UTF-8; one that was not is read as Latin-1, with a warning in `info`.
std::string marker_name_of(std::string_view bytes, TakeInfo& info);

}  // namespace risorius
