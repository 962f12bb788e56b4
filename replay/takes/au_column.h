// What the name of an AU column says: FACS number and side.
#pragma once

#include <string>
#include <string_view>

namespace risorius {

enum class ColumnSide : char { kNone = 0, kLeft = 'L', kRight = 'R' };

struct AuColumn {
  std::string name;  ///< as given
  int number = 0;    ///< of FACS; 0 where the name is not "AU" + number + optional "L" or "R"
  ColumnSide side = ColumnSide::kNone;
};

/// "AU12L" is AU 12 of the subject's left side; "mouthLeft" keeps its name and has neither number nor side.
AuColumn parse_au_column(std::string_view name);

}  // namespace risorius
