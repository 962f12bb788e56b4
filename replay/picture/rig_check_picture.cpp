#include "replay/picture/rig_check_picture.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace risorius {
namespace {

constexpr Colour kInk{0.15, 0.15, 0.18}, kGrey{0.45, 0.46, 0.5}, kGood{0.0, 0.45, 0.70}, kBad{0.84, 0.37, 0.0};
constexpr double kCell = 17, kLeft = 70, kTop = 96, kBarWidth = 260, kGap = 70;

/// White at 0, orange towards 1, blue towards -1.
Colour colour_of(double cosine) {
  const double share = std::min(1.0, std::abs(cosine));
  const Colour full = cosine >= 0 ? kBad : kGood;
  return {1 - share * (1 - full.red), 1 - share * (1 - full.green), 1 - share * (1 - full.blue)};
}

}  // namespace

Canvas draw_rig_check(const RigCheck& check, const std::string& title) {
  const auto count = static_cast<double>(check.aus.size());
  const double side = kCell * count, bars = kLeft + side + kGap;
  Canvas canvas(static_cast<int>(bars + kBarWidth + 110), static_cast<int>(kTop + side + 46));
  canvas.text({kLeft, 24}, title, 16, kInk);
  canvas.text({kLeft, 44},
              fmt::format("condition number {:.3g}; the rig leaves {:.2f} mm per marker; {} of {} frames solved",
                          check.condition, check.residual_rms_mm, check.solved, check.frames),
              12, kGrey);
  for (std::size_t i = 0; i < check.aus.size(); ++i) {
    const double y = kTop + kCell * static_cast<double>(i);
    const AuCheck& au = check.aus[i];
    canvas.text({kLeft - 6, y + 0.75 * kCell}, au.au, 11, kInk, TextAnchor::kRight);
    canvas.text({kLeft + kCell * (static_cast<double>(i) + 0.75), kTop - 5}, au.au, 10, kInk, TextAnchor::kLeft, true);
    for (std::size_t j = 0; j < check.aus.size(); ++j) {
      const double cosine = check.cosines(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      canvas.fill_rectangle({kLeft + kCell * static_cast<double>(j), y, kCell - 1, kCell - 1}, colour_of(cosine));
    }
    const double width = kBarWidth * std::min(1.0, au.deviation / 0.5);
    canvas.fill_rectangle({bars, y + 2, width, kCell - 5}, au.weak ? kBad : kGood);
    canvas.text({bars + width + 6, y + 0.75 * kCell}, fmt::format("{:.2f}", au.deviation), 11, kInk);
  }
  canvas.text({kLeft, kTop + side + 20},
              "How alike two AUs look to the markers, the head's pose taken out (orange: the same, blue: opposites)",
              12, kGrey);
  canvas.text({bars, kTop - 12}, "uncertainty of the intensity (orange: weakly observed)", 12, kGrey);
  return canvas;
}

}  // namespace risorius
