// Tables as a picture: cells with a background colour and text, heads that may run upwards, side by side on one canvas
// with a headline above and notes beneath.
#pragma once

#include <string>
#include <vector>

#include "replay/picture/canvas.h"

namespace risorius {

struct TableCell {
  std::string text;
  Colour background{1, 1, 1};
  bool is_bold = false;
};

struct TableColumn {
  std::string head;
  double width = 60;  ///< pixels
  TextAnchor anchor = TextAnchor::kRight;
};

struct PictureTable {
  std::string title;
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableCell>> rows;  ///< a cell per column
  std::vector<std::size_t> rules;            ///< rows with a line above them
  double row_height = 18, text_size = 11;    ///< pixels
  bool has_turned_heads = false;
};

/// Throws std::invalid_argument for a row that has not a cell per column, UserError for a picture that is too large.
Canvas table_picture(const std::string& headline, const std::vector<PictureTable>& tables,
                     const std::vector<std::string>& notes);

/// From white at 0 over amber at 1 to vermilion at 2 and beyond: how far a value went of what it may.
Colour warmth(double share) noexcept;

}  // namespace risorius
