// The expressions that the performer plays: prototypes by AU without side, with variants, out of expressions.json
// (compiled in).
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

using AuTargets = std::map<std::string, double, std::less<>>;  ///< AU without side -> intensity, 0 to 1

struct ExpressionTable {
  std::map<std::string, std::vector<std::string>, std::less<>> sets;       ///< "seed003", "seed001" -> names
  std::map<std::string, std::vector<AuTargets>, std::less<>> expressions;  ///< name -> variants; neutral has no targets
};

/// Throws UserError naming `place`, field, value and remedy.
ExpressionTable parse_expression_table(std::string_view json, const std::string& place);
const ExpressionTable& shipped_expression_table();

}  // namespace risorius
