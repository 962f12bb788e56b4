// The text of IEMOCAP's motion capture (USC SAIL): a line of marker names, a line `Frame# Time x y z x y z ...`, then
// one line per frame, blank-separated, mm, NaN where a marker is missing. Two sets of hand markers exist in the files;
// all that is not one of the 55 face markers is left out, with a warning.
#pragma once

#include "replay/takes/row_take_reader.h"

namespace risorius {

class IemocapReader final : public RowTakeReader {
 public:
  /// Throws UserError (file, line, value, remedy).
  IemocapReader(const std::filesystem::path& path, const TakeOptions& options);
};

}  // namespace risorius
