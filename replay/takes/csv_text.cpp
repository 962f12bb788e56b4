#include "replay/takes/csv_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <limits>

#include "capture/errors.h"

namespace risorius {
namespace {

bool is_blank(char c) noexcept { return c == ' ' || c == '\t'; }

std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

char separator_of(std::string_view header) noexcept {
  const auto count = [&](char c) { return std::count(header.begin(), header.end(), c); };
  if (count('\t') > count(',') && count('\t') > count(';')) return '\t';
  if (count(',') == 0 && count(';') == 0) return ' ';
  return count(';') > count(',') ? ';' : ',';
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) noexcept {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.empty() || text.front() == '+') return {};
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  if (value > std::numeric_limits<Number>::max() || value < std::numeric_limits<Number>::lowest()) return {};
  return value;
}

template <class Number>
void append_shortest(std::string& line, Number value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  line.append(digits.data(), end);
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path) : path_(path), file_(path, std::ios::binary) {
  if (!file_ || std::filesystem::is_directory(path))
    throw UserError(path.string(), "cannot be opened", "check the path and its permissions");
  rewind();
  separator_ = separator_of(line_);
  split_line();
  columns_.assign(cells_.begin(), cells_.end());
}

void CsvFile::rewind() {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  file_.clear();
  file_.seekg(0);
  if (!std::getline(file_, line_))
    throw UserError(path_.string(), "the file is empty", "its first line must name the columns");
  if (line_.starts_with(kByteOrderMark)) line_.erase(0, kByteOrderMark.size());
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  line_number_ = 1;
}

bool CsvFile::next_row() {
  while (std::getline(file_, line_)) {
    ++line_number_;
    if (!line_.empty() && line_.back() == '\r') line_.pop_back();
    if (trimmed(line_).empty()) continue;
    split_line();
    if (cells_.size() != columns_.size())
      throw UserError(place(),
                      std::to_string(cells_.size()) + " cells where the header names " +
                          std::to_string(columns_.size()) + " columns",
                      "the line is cut short, or a text with the separator in it is not quoted");
    return true;
  }
  if (file_.bad()) throw UserError(path_.string(), "cannot be read", "check the disk");
  return false;
}

std::string CsvFile::place() const { return path_.string() + ", line " + std::to_string(line_number_); }

void CsvFile::fail_at(std::size_t column, const std::string& remedy) const {
  fail_at(column, fmt::format("'{}' is no number", shown(cells_[column])), remedy);
}

void CsvFile::fail_at(std::size_t column, const std::string& problem, const std::string& remedy) const {
  throw UserError(place() + ", column " + shown(columns_[column]), problem, remedy);
}

void CsvFile::split_line() {
  cells_.clear();
  // Quoted cells are unfolded in place: they only become shorter.
  for (std::size_t at = 0;;) {
    while (at < line_.size() && is_blank(line_[at]) && line_[at] != separator_) ++at;
    if (at < line_.size() && line_[at] == '"') {
      const std::size_t begin = at;
      std::size_t end = at++;
      for (;; ++at) {
        if (at >= line_.size())
          throw UserError(place(), "a quote is opened and never closed", "close it on the same line");
        if (line_[at] == '"' && (at + 1 >= line_.size() || line_[at + 1] != '"')) break;
        if (line_[at] == '"') ++at;
        line_[end++] = line_[at];
      }
      cells_.push_back(std::string_view(line_).substr(begin, end - begin));
      at = std::min(line_.find(separator_, at), line_.size());
    } else {
      const std::size_t end = std::min(line_.find(separator_, at), line_.size());
      cells_.push_back(trimmed(std::string_view(line_).substr(at, end - at)));
      at = end;
    }
    if (at++ == line_.size()) return;
  }
}

std::optional<double> parse_double(std::string_view text) noexcept { return parse_number<double>(text); }
std::optional<float> parse_float(std::string_view text) noexcept { return parse_number<float>(text); }

void append_number(std::string& line, double value) { append_shortest(line, value); }
void append_number(std::string& line, float value) { append_shortest(line, value); }
void append_number(std::string& line, std::uint64_t value) { append_shortest(line, value); }

void append_seconds(std::string& line, std::int64_t time_ns) {
  constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;
  const bool negative = time_ns < 0;
  const std::uint64_t magnitude =
      negative ? ~static_cast<std::uint64_t>(time_ns) + 1 : static_cast<std::uint64_t>(time_ns);
  if (negative) line += '-';
  append_shortest(line, magnitude / kNanosecondsPerSecond);
  std::string fraction = std::to_string(kNanosecondsPerSecond + magnitude % kNanosecondsPerSecond).substr(1);
  while (!fraction.empty() && fraction.back() == '0') fraction.pop_back();
  if (!fraction.empty()) line += "." + fraction;
}

void append_text(std::string& line, std::string_view text) {
  const bool plain = text.find_first_of(",;\t\"\r\n") == std::string_view::npos && trimmed(text).size() == text.size();
  if (plain) {
    line += text;
    return;
  }
  line += '"';
  for (const char c : text) {
    if (c == '"') line += '"';
    line += c;
  }
  line += '"';
}

}  // namespace risorius
