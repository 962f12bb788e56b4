// The files of the study's page (study/page/), compiled in.
#pragma once

#include <string_view>

namespace risorius {

/// By file name. Throws std::invalid_argument for a name that is not there.
std::string_view shipped_page_file(std::string_view name);

}  // namespace risorius
