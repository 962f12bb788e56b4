// TRC, Motion Analysis's text format of takes: five header lines (file type; the names and the values of the take's
// properties; Frame#, Time and the marker names; X1 Y1 Z1 ...), a blank line, then one line per frame, tab-separated.
#pragma once

#include "replay/takes/row_take_reader.h"

namespace risorius {

class TrcReader final : public RowTakeReader {
 public:
  /// Reads the header and counts the frames. Unit and rate are the header's unless the options say otherwise. Throws
  /// UserError (file, line, value, remedy).
  TrcReader(const std::filesystem::path& path, const TakeOptions& options);

 private:
  double read_properties(const TakeOptions& options);
  std::vector<std::size_t> read_names();
};

}  // namespace risorius
