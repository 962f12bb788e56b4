// Reads the points of a C3D file (c3d.org; all six encodings) frame by frame. What a file leaves out or contradicts is
// told in info().warnings; replay/README.md lists the conventions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "replay/takes/c3d_layout.h"
#include "replay/takes/take.h"

namespace risorius {

class C3dReader final : public TakeReader {
 public:
  /// Reads header and parameters. Throws UserError (file, field, value, remedy).
  C3dReader(const std::filesystem::path& path, const TakeOptions& options);

  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override;
  void rewind() override;

 private:
  void decode_point(const std::uint8_t* bytes, std::size_t index, MarkerFrame& frame) const noexcept;

  TakeInfo info_;
  C3dLayout layout_;
  std::vector<char> stream_buffer_;
  std::ifstream file_;
  std::vector<std::uint8_t> frame_bytes_;
  std::uint64_t next_index_ = 0;
};

}  // namespace risorius
