// The landmarks of BU-4DFE (Binghamton): one .bnd file per frame with lines `index x y z`, the same indices in each. A
// folder of them is a take, in the order of the numbers in their names, a lacking number being a lost frame; a single
// file is a take of one frame.
#pragma once

#include <filesystem>
#include <vector>

#include "replay/takes/take.h"

namespace risorius {

class BndReader final : public TakeReader {
 public:
  static constexpr double kRateHz = 25;  ///< BU-4DFE's own, unless the options give one

  /// Finds the files and reads the first one: its indices are the landmarks' names, "L01" and so on. Throws UserError.
  BndReader(const std::filesystem::path& path, const TakeOptions& options);

  const TakeInfo& info() const noexcept override { return info_; }
  /// Throws UserError (file, line, remedy) where a file is damaged or has other indices than the first.
  bool next(MarkerFrame& frame) override;
  void rewind() override { next_ = 0; }

 private:
  struct Landmark {
    int index = 0;
    double x = 0, y = 0, z = 0;
  };
  static std::vector<Landmark> read_landmarks(const std::filesystem::path& file);

  TakeInfo info_;
  std::vector<std::filesystem::path> files_;
  std::vector<std::uint64_t> sequence_;  ///< of the files, from 0
  std::vector<int> indices_;
  std::size_t next_ = 0;
};

}  // namespace risorius
