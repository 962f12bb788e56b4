// Comma-separated text: lines of a file, cells of a line, numbers of cells. Knows quotes, CRLF, a byte order mark, and
// the separators , ; and tab, and single blanks where the header has none of these.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

/// Reads a CSV file line by line; the first line is the header. Blank lines are skipped.
class CsvFile {
 public:
  /// Opens, reads the header and finds the separator in it. Throws UserError.
  explicit CsvFile(const std::filesystem::path& path);

  const std::vector<std::string>& columns() const noexcept { return columns_; }
  /// Splits the next line into cells; false at the end of the file. Throws UserError (file, line) unless the line has
  /// as many cells as the header.
  bool next_row();
  /// Without surrounding blanks and quotes; valid until the next call of next_row.
  std::string_view cell(std::size_t column) const noexcept { return cells_[column]; }
  /// "FILE, line N" of the current row.
  std::string place() const;
  /// Throws UserError: the cell is no number.
  [[noreturn]] void fail_at(std::size_t column, const std::string& remedy) const;
  [[noreturn]] void fail_at(std::size_t column, const std::string& problem, const std::string& remedy) const;
  /// Back to the first row.
  void rewind();

 private:
  void split_line();

  std::filesystem::path path_;
  std::ifstream file_;
  char separator_ = ',';
  std::vector<std::string> columns_;
  std::string line_;
  std::uint64_t line_number_ = 0;
  std::vector<std::string_view> cells_;
};

/// The whole text as a number with a decimal point; empty if it is none or out of range. "nan" in any case is NaN.
std::optional<double> parse_double(std::string_view text) noexcept;
std::optional<float> parse_float(std::string_view text) noexcept;

/// Appends with the fewest digits that read back as the same bits.
void append_number(std::string& line, double value);
void append_number(std::string& line, float value);
void append_number(std::string& line, std::uint64_t value);
/// Nanoseconds as seconds, exactly: "-1.25", "0.016666667".
void append_seconds(std::string& line, std::int64_t time_ns);
/// Quoted where commas, quotes, line ends or outer blanks make it necessary.
void append_text(std::string& line, std::string_view text);

}  // namespace risorius
