// A named expression of the performer's table as intensities of given AU columns: what a transition or a live target
// leads to.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "replay/performer/expression_table.h"

namespace risorius {

struct ExpressionVector {
  std::vector<double> intensities;  ///< one per name, 0 where the expression does not move it
  std::vector<std::string> masked;  ///< AUs of the expression that the names do not hold
};

/// `expression` is a name of the table, such as "happy", or one of its variants, such as "happy:2" (from 1; without a
/// number the first). An AU without side moves both sides; AU27 moves AU26 where there is no other jaw. Throws
/// UserError naming what there is.
ExpressionVector expression_vector(std::string_view expression, const std::vector<std::string>& names,
                                   const ExpressionTable& table = shipped_expression_table());

/// "disgusted, frowning, happy, ...".
std::string expression_names(const ExpressionTable& table = shipped_expression_table());

}  // namespace risorius
