#include "replay/takes/take_names.h"

#include <fmt/format.h>

#include "capture/errors.h"
#include "capture/utf8.h"

namespace risorius {

std::string marker_name_of(std::string_view bytes, TakeInfo& info) {
  if (is_clean_utf8(bytes)) return std::string(bytes);
  std::string name = utf8_of(bytes);
  info.warnings.push_back(fmt::format("a marker's name is not UTF-8: read as Latin-1, '{}'", shown(name)));
  return name;
}

}  // namespace risorius
