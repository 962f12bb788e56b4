// AU series as CSV in the layout of seed 003: `Frame,AU1L,AU1R,...`, a decimal point, an empty cell where an AU was not
// observed. Numbers have the fewest digits that read back as the same bits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/frames.h"
#include "replay/atomic_file.h"
#include "replay/takes/au_series.h"

namespace risorius {

class AuCsvWriter {
 public:
  /// 1 to kMaxAus names. Throws UserError.
  AuCsvWriter(const std::filesystem::path& path, const std::vector<std::string>& au_names);

  /// `Frame` is the frame's sequence. Held intensities are not observed: their cells are empty. Throws
  /// std::invalid_argument if the frame has another number of AUs than there are names.
  void write(const AuFrame& frame);
  /// Completes the file; without it there is none. Throws UserError.
  void finish();
  AtomicFile& file() noexcept { return file_; }

 private:
  std::size_t au_count_;
  AtomicFile file_;
  std::string line_;
};

/// Throws UserError (file, line, column, value, remedy).
AuSeries load_au_csv(const std::filesystem::path& path);

}  // namespace risorius
