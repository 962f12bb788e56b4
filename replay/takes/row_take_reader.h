// What takes have in common that are text with one line per frame (TRC, IEMOCAP): cells split at tabs or blanks, a
// frame number, a time, then x, y and z of each marker. A format's reader is its header; the rows are read here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "replay/takes/take.h"

namespace risorius {

class RowTakeReader : public TakeReader {
 public:
  const TakeInfo& info() const noexcept override { return info_; }
  /// Frame numbers that leap are lost frames: the sequence leaps with them. Throws UserError (file, line, value,
  /// remedy).
  bool next(MarkerFrame& frame) override;
  void rewind() override;

 protected:
  enum class Cells { kTabs, kBlanks };  ///< separated by one tab each (so cells may be empty), or by any blanks

  /// Opens. Throws UserError.
  RowTakeReader(const std::filesystem::path& path, Cells cells);

  /// The next line without its end, split; false at the end of the file.
  bool next_line();
  const std::vector<std::string_view>& cells() const noexcept { return cells_; }
  /// "FILE, line N" of the current line.
  std::string place() const;

  struct Header {
    std::vector<std::size_t> first_cells;  ///< where each marker's x stands
    std::size_t row_cells = 0;             ///< that a line has at most; more is an error, or left out with a warning
    bool has_unnamed_cells = false;        ///< the format knows cells beyond the named markers
    double rate_hz = 0;                    ///< 0: not stated
  };
  /// Once the header is read. Counts the frames; takes the rate from `options`, else from the header, else from the
  /// times. Throws UserError if there is none, or no frame.
  void begin_rows(Header header, const TakeOptions& options);

  TakeInfo info_;

 private:
  bool next_row();
  void scan_rows(double rate_hz);
  std::uint64_t frame_number() const;
  void read_marker(std::size_t marker, MarkerFrame& frame) const;
  double number_at(std::size_t cell) const;

  Cells separation_;
  std::ifstream file_;
  std::string line_;
  std::uint64_t line_number_ = 0;
  std::vector<std::string_view> cells_;

  Header header_;
  std::streampos rows_begin_;
  std::uint64_t rows_begin_line_ = 0;
  std::uint64_t first_frame_ = 0;
  std::optional<std::uint64_t> last_sequence_;
};

}  // namespace risorius
