// build/bench/solve_accuracy.png: crosstalk of the causal solve, lag per AU, and RMSE per AU of the methods compared.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/au_accuracy.h"

namespace risorius::bench {

struct MethodAccuracy {
  std::string name;
  AuAccuracy accuracy;
};

void draw_accuracy(const std::string& title, const std::vector<AuTie>& ties, const std::vector<MethodAccuracy>& methods,
                   const Eigen::MatrixXd& crosstalk, double frame_ms, const std::filesystem::path& path);

}  // namespace risorius::bench
