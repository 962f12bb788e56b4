#include "replay/evaluation/expression_table_pictures.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

#include "replay/corpus/expression_corpus.h"
#include "replay/picture/table_picture.h"

namespace risorius {
namespace {

constexpr Colour kNothing{0.93, 0.93, 0.94};
constexpr const char* kBoldNote =
    "Bold: the pairs of seed 003's Table 4.2. *: a performance that was never trained on.";

const char* sign_of(TransitionRating rating) {
  return rating == TransitionRating::kInconspicuous ? "+" : rating == TransitionRating::kNarrow ? "o" : "\u2212";
}

Colour colour_of(TransitionRating rating) {
  return rating == TransitionRating::kInconspicuous ? Colour{0.82, 0.9, 0.97}
         : rating == TransitionRating::kNarrow      ? warmth(1)
                                                    : warmth(2);
}

/// From, to and variant of a row; the expressions once per pair, in its first row.
template <class Row>
std::vector<TableCell> key_cells(const std::vector<Row>& rows, std::size_t i) {
  const Row& row = rows[i];
  const bool is_new = i == 0 || rows[i - 1].from != row.from || rows[i - 1].to != row.to;
  const bool is_bold = is_seed003_pair(row.from, row.to);
  return {{.text = is_new ? row.from : "", .is_bold = is_bold},
          {.text = is_new ? row.to : "", .is_bold = is_bold},
          {.text = fmt::format("{}{}", row.variant + 1, row.is_seen ? "" : "*")}};
}

const std::vector<TableColumn> kKeyColumns{
    {"from", 72, TextAnchor::kLeft}, {"to", 72, TextAnchor::kLeft}, {"variant", 34, TextAnchor::kRight}};

std::string jump_text(double percent) {
  return percent < 0.05 ? "" : fmt::format("{:.{}f}", percent, percent < 99.95 ? 1 : 0);
}

/// The first and the last row of each pair: seed 003 shows its first and its fifth variant.
std::vector<JumpRow> ends_of_pairs(const std::vector<JumpRow>& rows) {
  std::vector<JumpRow> chosen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto same_pair = [&](std::size_t j) { return rows[j].from == rows[i].from && rows[j].to == rows[i].to; };
    if (i == 0 || !same_pair(i - 1) || i + 1 == rows.size() || !same_pair(i + 1)) chosen.push_back(rows[i]);
  }
  return chosen;
}

PictureTable rating_table(const ScoredModel& model, bool of_seen) {
  const RatingMatrix matrix = rating_matrix(model, of_seen);
  const TableSummary sum = table_summary(model, of_seen);
  PictureTable table{
      .title = fmt::format("{}: {} +, {} o, {} \u2212",
                           of_seen ? "performances that the default was trained on" : "performances never trained on",
                           sum.inconspicuous, sum.narrow, sum.conspicuous),
      .columns = {{"from \\ to", 90, TextAnchor::kLeft}},
      .row_height = 34,
      .text_size = 13};
  for (const std::string& to : matrix.expressions) table.columns.push_back({to, 84, TextAnchor::kCentre});
  for (std::size_t from = 0; from < matrix.expressions.size(); ++from) {
    std::vector<TableCell> row{{.text = matrix.expressions[from]}};
    for (std::size_t to = 0; to < matrix.expressions.size(); ++to) {
      const RatingCell& cell = matrix.cells[from][to];
      TableCell& drawn = row.emplace_back();
      drawn.background = cell.ratings.empty() ? kNothing : colour_of(cell.worst());
      drawn.is_bold = is_seed003_pair(matrix.expressions[from], matrix.expressions[to]);
      for (const TransitionRating rating : cell.ratings)
        drawn.text += fmt::format("{}{}", drawn.text.empty() ? "" : "  ", sign_of(rating));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

PictureTable summary_table(std::span<const ScoredModel> models, bool of_seen) {
  PictureTable table{
      .title = of_seen ? "performances that the default was trained on" : "performances never trained on",
      .columns = {{"", 210, TextAnchor::kLeft}}};
  for (const char* head : {"transitions", "mean E", "of bold pairs", "mean jump, %", "of bold pairs", "largest jump, %",
                           "+", "o", "\u2212"})
    table.columns.push_back({head, 52});
  table.has_turned_heads = true;
  for (const ScoredModel& model : models) {
    const TableSummary all = table_summary(model, of_seen), known = table_summary(model, of_seen, TablePairs::kSeed003);
    const auto count = [](std::size_t n) { return TableCell{.text = std::to_string(n)}; };
    const auto value = [](double v, double limit) { return TableCell{fmt::format("{:.2f}", v), warmth(v / limit)}; };
    table.rows.push_back({{.text = model.name},
                          count(all.count),
                          value(all.mean_error, 1),
                          value(known.mean_error, 1),
                          value(all.mean_jump_percent, 20),
                          value(known.mean_jump_percent, 20),
                          value(all.largest_jump_percent, 40),
                          count(all.inconspicuous),
                          count(all.narrow),
                          count(all.conspicuous)});
  }
  return table;
}

}  // namespace

Canvas error_picture(std::span<const ScoredModel> models) {
  const std::vector<ErrorRow> rows = error_rows(models);
  PictureTable empty{.columns = kKeyColumns, .row_height = 15, .text_size = 10, .has_turned_heads = true};
  for (const ScoredModel& model : models) empty.columns.push_back({model.name, 44});
  std::vector<PictureTable> tables{empty};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_new_start = i > 0 && rows[i].from != rows[i - 1].from;
    if (is_new_start && tables.size() == 1 && 2 * i >= rows.size()) tables.push_back(empty);
    PictureTable& table = tables.back();
    if (is_new_start && !table.rows.empty()) table.rules.push_back(table.rows.size());
    table.rows.push_back(key_cells(rows, i));
    for (const double error : rows[i].errors)
      table.rows.back().push_back({fmt::format("{:.2f}", error), warmth(error)});
  }
  return table_picture(
      "Absolute error of each transition, after seed 003's Tables 6.6 to 6.8", tables,
      {"E: sum over frames of the mean over AUs of (made - truth)\u00b2. Above 1, where amber begins to "
       "redden, a transition is conspicuous.",
       kBoldNote});
}

Canvas jump_picture(const ScoredModel& model, const std::vector<std::string>& au_names) {
  const std::vector<JumpRow> rows = ends_of_pairs(jump_rows(model));
  PictureTable table{.columns = kKeyColumns, .row_height = 15, .text_size = 9, .has_turned_heads = true};
  for (const std::string& name : au_names) table.columns.push_back({name, 27});
  for (const char* head : {"least", "mean", "most"}) table.columns.push_back({head, 36});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].percent.size() != au_names.size())
      throw std::invalid_argument("jump_picture: other AUs than there are names");
    if (i > 0 && rows[i].from != rows[i - 1].from) table.rules.push_back(i);
    std::vector<TableCell>& cells = table.rows.emplace_back(key_cells(rows, i));
    for (const double jump : rows[i].percent) cells.push_back({jump_text(jump), warmth(jump / 20)});
    for (const double jump : {rows[i].least, rows[i].mean, rows[i].most})
      cells.push_back({fmt::format("{:.2f}", jump), warmth(jump / 20)});
  }
  return table_picture(fmt::format("{}: jump at the first generated frame, after seed 003's appendix C", model.name),
                       {table},
                       {"|x1 - x0| in % of the full range 1.2; empty: below 0.05 %. Amber: 20 %, of which three are "
                        "conspicuous; vermilion: 40 %, of which "
                        "one is.",
                        kBoldNote});
}

Canvas rating_picture(const ScoredModel& model) {
  return table_picture(
      fmt::format("{}: from expression to expression, after seed 003's Table 7.1", model.name),
      {rating_table(model, true), rating_table(model, false)},
      {"A sign per variant; the colour is the worst one's. +  not conspicuous;  o  by one criterion, and that by a "
       "quarter of its threshold at most;  \u2212  conspicuous.",
       "Conspicuous: E > 1, or a jump > 40 %, or three > 20 %, or reactivation > 25 %, or an end off by > 25 %.",
       "Bold: the pairs of seed 003's Table 4.2."});
}

Canvas summary_picture(std::span<const ScoredModel> models) {
  return table_picture(
      "Transitions between six expressions", {summary_table(models, true), summary_table(models, false)},
      {"E: absolute error. Jump: at the first generated frame, in % of the full range 1.2, over all AUs. "
       "Bold pairs: the 17 of seed 003's Table 4.2."});
}

}  // namespace risorius
