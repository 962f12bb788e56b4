// Writes marker frames as a C3D file: Intel, float, mm, the axes of Risorius (LUF). Streams; the counts of the header
// are filled in by finish(). Conventions for missing and filled points: replay/README.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "replay/atomic_file.h"
#include "replay/takes/take.h"

namespace risorius {

class C3dWriter final : public TakeWriter {
 public:
  /// The set's rate must be above 0; its unit and axes are not used: frames are in mm and LUF. `software_version` goes
  /// into MANUFACTURER:VERSION_LABEL. Throws UserError.
  C3dWriter(const std::filesystem::path& path, MarkerSet markers, std::string software_version);

  /// Frames follow each other at the set's rate: C3D keeps no time per frame. Throws std::invalid_argument if the frame
  /// has another number of markers than the set.
  void write(const MarkerFrame& frame) override;
  void finish() override;

  AtomicFile& file() noexcept { return file_; }
  std::uint64_t frame_count() const noexcept { return frame_count_; }
  /// After the file was cut behind so many frames.
  void resume_at(std::uint64_t frame_count) noexcept { frame_count_ = frame_count; }

 private:
  MarkerSet markers_;
  std::string software_version_;
  AtomicFile file_;
  std::string frame_bytes_;
  std::uint64_t frame_count_ = 0;
};

}  // namespace risorius
