#include "replay/picture/table_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace risorius {
namespace {

constexpr Colour kInk{0.15, 0.15, 0.18}, kRule{0.45, 0.46, 0.5}, kGrid{0.88, 0.89, 0.91};
constexpr double kMargin = 16, kBetween = 28, kCellPadding = 5, kHeadlineSize = 17, kTitleSize = 14, kNoteSize = 12;
constexpr double kHeadline = 34, kTitle = 26, kNote = 18;

/// Twice, a pixel apart (glyphs stand on whole pixels): the one typeface that Canvas has looks bold so.
void draw_text(Canvas& canvas, PicturePoint at, const std::string& text, double size, TextAnchor anchor, bool is_bold) {
  canvas.text(at, text, size, kInk, anchor);
  if (is_bold) canvas.text({at.x + 1, at.y}, text, size, kInk, anchor);
}

double width_of(const PictureTable& table) {
  double width = 0;
  for (const TableColumn& column : table.columns) width += column.width;
  return width;
}

double head_height(const Canvas& canvas, const PictureTable& table) {
  double height = table.row_height;
  if (!table.has_turned_heads) return height;
  for (const TableColumn& column : table.columns)
    height = std::max(height, canvas.text_width(column.head, table.text_size) + 2 * kCellPadding);
  return height;
}

double height_of(const Canvas& canvas, const PictureTable& table) {
  return kTitle + head_height(canvas, table) + table.row_height * static_cast<double>(table.rows.size());
}

/// Where text of a column begins, ends or has its middle.
double anchor_x(double left, const TableColumn& column) {
  return column.anchor == TextAnchor::kLeft     ? left + kCellPadding
         : column.anchor == TextAnchor::kCentre ? left + column.width / 2
                                                : left + column.width - kCellPadding;
}

void draw_heads(Canvas& canvas, PicturePoint at, double height, const PictureTable& table) {
  double left = at.x;
  for (const TableColumn& column : table.columns) {
    // Names of rows are read upright, and single signs: a turned minus is a bar.
    const bool is_turned = table.has_turned_heads && column.anchor != TextAnchor::kLeft &&
                           canvas.text_width(column.head, table.text_size) > table.text_size;
    if (is_turned) {
      canvas.text({left + column.width / 2 + 0.35 * table.text_size, at.y + height - kCellPadding}, column.head,
                  table.text_size, kInk, TextAnchor::kLeft, true);
    } else {
      canvas.text({anchor_x(left, column), at.y + height - kCellPadding}, column.head, table.text_size, kInk,
                  column.anchor);
    }
    left += column.width;
  }
}

void draw_table(Canvas& canvas, PicturePoint at, const PictureTable& table) {
  canvas.text({at.x, at.y + kTitleSize + 2}, table.title, kTitleSize, kInk);
  const double head = head_height(canvas, table), width = width_of(table);
  draw_heads(canvas, {at.x, at.y + kTitle}, head, table);
  const double top = at.y + kTitle + head;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double y = top + static_cast<double>(row) * table.row_height;
    double left = at.x;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const TableColumn& column = table.columns[c];
      const TableCell& cell = table.rows[row][c];
      canvas.fill_rectangle({left, y, column.width, table.row_height}, cell.background);
      draw_text(canvas, {anchor_x(left, column), y + table.row_height / 2 + 0.35 * table.text_size}, cell.text,
                table.text_size, column.anchor, cell.is_bold);
      left += column.width;
    }
    if (row > 0) canvas.line({at.x, y}, {at.x + width, y}, kGrid);
  }
  const auto rule = [&](std::size_t row) {
    const double y = top + static_cast<double>(row) * table.row_height;
    canvas.line({at.x, y}, {at.x + width, y}, kRule);
  };
  rule(0);
  rule(table.rows.size());
  for (const std::size_t row : table.rules) rule(row);
}

}  // namespace

Canvas table_picture(const std::string& headline, const std::vector<PictureTable>& tables,
                     const std::vector<std::string>& notes) {
  const Canvas ruler(1, 1);
  double width = ruler.text_width(headline, kHeadlineSize), height = 0, across = 0;
  for (const std::string& note : notes) width = std::max(width, ruler.text_width(note, kNoteSize));
  for (const PictureTable& table : tables) {
    for (const auto& row : table.rows) {
      if (row.size() != table.columns.size())
        throw std::invalid_argument("table_picture: a row has not as many cells as there are columns");
    }
    across += width_of(table) + (across > 0 ? kBetween : 0);
    height = std::max(height, height_of(ruler, table));
  }
  width = std::ceil(std::max(width, across) + 2 * kMargin);
  const double notes_top = kMargin + kHeadline + height + kNote;
  Canvas canvas(static_cast<int>(width),
                static_cast<int>(std::ceil(notes_top + kNote * static_cast<double>(notes.size()) + kMargin)));
  canvas.text({kMargin, kMargin + kHeadlineSize}, headline, kHeadlineSize, kInk);
  double left = kMargin;
  for (const PictureTable& table : tables) {
    draw_table(canvas, {left, kMargin + kHeadline}, table);
    left += width_of(table) + kBetween;
  }
  for (std::size_t i = 0; i < notes.size(); ++i)
    canvas.text({kMargin, notes_top + kNote * static_cast<double>(i) + kNoteSize}, notes[i], kNoteSize, kInk);
  return canvas;
}

Colour warmth(double share) noexcept {
  constexpr Colour kWhite{1, 1, 1}, kAmber{1, 0.9, 0.62}, kVermilion{0.95, 0.6, 0.42};
  const auto between = [](Colour a, Colour b, double t) {
    return Colour{a.red + t * (b.red - a.red), a.green + t * (b.green - a.green), a.blue + t * (b.blue - a.blue)};
  };
  if (!(share > 0)) return kWhite;
  return share < 1 ? between(kWhite, kAmber, share) : between(kAmber, kVermilion, std::min(share - 1, 1.0));
}

}  // namespace risorius
