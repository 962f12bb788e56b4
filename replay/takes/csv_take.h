// Takes as CSV: `frame,time_s,NAME_x,NAME_y,NAME_z,...`, one line per frame, an empty cell or NaN where a marker is
// missing. The format is specified in replay/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "replay/atomic_file.h"
#include "replay/takes/csv_text.h"
#include "replay/takes/take.h"

namespace risorius {

/// What the columns frame and time_s of a take say. N frames.
struct CsvTakeTimes {
  std::vector<std::int64_t> times_ns;  ///< N, growing; empty without time_s
  std::vector<std::uint64_t> numbers;  ///< N, from 0, growing; empty where they are 0, 1, 2...
  std::uint64_t number_of(std::size_t index) const noexcept { return numbers.empty() ? index : numbers[index]; }
};

/// Unit mm and axes LUF unless the options say otherwise. Times on a grid of equal steps become exact multiples of the
/// step; others are kept as capture times, with a warning. Frame numbers that leap are lost frames: the sequence leaps
/// with them. Times and frame numbers that do not grow are refused.
class CsvTakeReader final : public TakeReader {
 public:
  /// Reads the header and all times. Throws UserError (file, line, column, value, remedy).
  CsvTakeReader(const std::filesystem::path& path, const TakeOptions& options);

  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override;
  void rewind() override;

 private:
  using Columns = std::array<std::size_t, 3>;  ///< of x, y and z

  void assign_columns();
  void check_columns() const;
  [[noreturn]] void fail_in_header(const std::string& column, const std::string& problem,
                                   const std::string& remedy) const;
  std::uint64_t read_frame_number(const std::optional<std::uint64_t>& last) const;
  CsvTakeTimes scan_times();
  void settle_times(CsvTakeTimes times, const std::optional<double>& given_rate_hz);
  std::uint64_t number_of(std::uint64_t index) const noexcept { return numbers_.empty() ? index : numbers_[index]; }
  float read_coordinate_mm(std::size_t column) const;
  std::int64_t capture_time_ns() const noexcept;

  TakeInfo info_;
  CsvFile file_;
  std::vector<Columns> columns_of_marker_;
  std::optional<std::size_t> frame_column_, time_column_;
  std::vector<std::uint64_t> numbers_;            ///< of the frames from 0; empty where none is lost
  std::vector<std::int64_t> irregular_times_ns_;  ///< empty where time is start + index / rate
  std::int64_t start_time_ns_ = 0;                ///< of index 0 of the grid
  std::uint64_t start_index_ = 0;                 ///< of the first frame on the grid
  std::uint64_t next_index_ = 0;
};

/// Positions in mm and LUF axes, written so that they read back with equal bits; filled markers as positions, missing
/// and rejected ones as empty cells.
class CsvTakeWriter final : public TakeWriter {
 public:
  CsvTakeWriter(const std::filesystem::path& path, MarkerSet markers);

  /// Throws std::invalid_argument if the frame has another number of markers than the set.
  void write(const MarkerFrame& frame) override;
  void finish() override;

 private:
  std::size_t marker_count_;
  AtomicFile file_;
  std::string line_;
};

}  // namespace risorius
