// The truth of a performance beside its take: what the face did (AU CSV), where the head was (pose CSV), what became of
// every marker (markers CSV), what was meant when (cues CSV). Their forms stand in replay/README.md.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "capture/frames.h"
#include "replay/atomic_file.h"
#include "replay/performer/marker_defects.h"
#include "replay/performer/performer_script.h"
#include "replay/takes/au_csv.h"

namespace risorius {

/// One line per frame: `frame,causes`, one letter per marker in the take's order (DefectCause).
class CauseWriter {
 public:
  explicit CauseWriter(const std::filesystem::path& path);
  void write(std::uint64_t frame, std::span<const DefectCause> causes);
  void finish();

 private:
  AtomicFile file_;
  std::string line_;
};

/// AU.csv, and AU.pose.csv, AU.markers.csv, AU.cues.csv beside it (for AU.csv = the path given).
class TruthWriter {
 public:
  /// Throws UserError.
  TruthWriter(const std::filesystem::path& au_csv, const std::vector<std::string>& au_names);

  void write(const AuFrame& truth, std::span<const DefectCause> causes);
  /// Completes the files; `cues` may be empty.
  void finish(const std::vector<ScriptCue>& cues);
  /// Paths of all four.
  /// The files that a writer for `au_csv` makes, that one first.
  static std::vector<std::filesystem::path> paths_for(const std::filesystem::path& au_csv);
  const std::vector<std::filesystem::path>& paths() const noexcept { return paths_; }

 private:
  std::vector<std::filesystem::path> paths_;
  AuCsvWriter aus_;
  AtomicFile poses_;
  CauseWriter causes_;
  std::string line_;
};

}  // namespace risorius
