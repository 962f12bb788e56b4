#include "bench/accuracy_pictures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "replay/picture/canvas.h"
#include "replay/picture/plot.h"

namespace risorius::bench {
namespace {

constexpr double kCell = 13, kLabels = 70;

/// Row: true AU; column: solved AU. White is 0, blue positive, red negative; the diagonal should be dark blue, all else
/// white.
void draw_crosstalk(Canvas& canvas, double left, double top, const std::vector<AuTie>& ties,
                    const Eigen::MatrixXd& crosstalk) {
  canvas.text({left, top + 14},
              "crosstalk, causal, AUs one by one: what the true AU (row) does to the solved one (column)", 13);
  top += 30;
  const auto count = static_cast<double>(ties.size());
  for (std::size_t j = 0; j < ties.size(); ++j) {
    const std::string name = ties[j].name.substr(0, 10);
    const double at = static_cast<double>(j) * kCell;
    canvas.text({left + kLabels - 4, top + at + kCell - 3}, name, 9, {}, TextAnchor::kRight);
    canvas.text({left + kLabels + at + kCell - 3, top + count * kCell + kLabels - 4}, name, 9, {}, TextAnchor::kLeft,
                true);
    for (std::size_t i = 0; i < ties.size(); ++i) {
      const double value = std::clamp(crosstalk(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)), -1.0, 1.0);
      const double fade = 1 - std::abs(value);
      const Colour colour = value > 0 ? Colour{fade, 0.35 + 0.65 * fade, 0.7 + 0.3 * fade, 1}
                                      : Colour{0.8 + 0.2 * fade, 0.3 + 0.7 * fade, fade, 1};
      canvas.fill_rectangle({left + kLabels + static_cast<double>(i) * kCell, top + at, kCell - 1, kCell - 1}, colour);
    }
  }
}

std::vector<double> as_vector(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

}  // namespace

void draw_accuracy(const std::string& title, const std::vector<AuTie>& ties, const std::vector<MethodAccuracy>& methods,
                   const Eigen::MatrixXd& crosstalk, double frame_ms, const std::filesystem::path& path) {
  const double matrix = kLabels * 2 + kCell * static_cast<double>(ties.size()) + 40;
  Canvas canvas(static_cast<int>(matrix + 620), static_cast<int>(std::max(matrix + 30, 640.0)));
  canvas.text({12, 22}, title, 15);
  draw_crosstalk(canvas, 10, 34, ties, crosstalk);
  Plot rmse({"RMSE of an AU", "RMSE", "share of AUs"});
  Plot lag({"lag of an AU", "lag, ms", "share of AUs"});
  for (std::size_t i = 0; i < methods.size(); ++i) {
    rmse.ecdf(as_vector(methods[i].accuracy.rmse), plot_colour(i), methods[i].name);
    std::vector<double> ms;
    for (const double frames : methods[i].accuracy.lag_frames) {
      if (std::isfinite(frames)) ms.push_back(frames * frame_ms);
    }
    lag.ecdf(ms, plot_colour(i), methods[i].name);
  }
  rmse.logarithmic_x();
  lag.limit_x(-4 * frame_ms, 4 * frame_ms);
  lag.mark_x(frame_ms, {0.6, 0.6, 0.6, 1});
  rmse.draw(canvas, {matrix, 40, 600, 290});
  lag.draw(canvas, {matrix, 335, 600, 290});
  canvas.save_png(path);
}

}  // namespace risorius::bench
