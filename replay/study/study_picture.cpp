#include "replay/study/study_picture.h"

#include <fmt/format.h>
#include <stdexcept>
#include <string>

#include "replay/picture/plot.h"

namespace risorius {
namespace {

constexpr int kWidth = 980, kHead = 64, kRow = 58, kFoot = 66;
constexpr double kLeft = 210, kRight = kWidth - 210.0, kBarHeight = 20;
constexpr Colour kInk{0.15, 0.15, 0.18}, kGrey{0.45, 0.45, 0.48}, kRule{0.86, 0.86, 0.88}, kPaper{1, 1, 1};

double x_of(double share) { return kLeft + share * (kRight - kLeft); }

void draw_scale(Canvas& canvas, double bottom) {
  for (int percent = 0; percent <= 100; percent += 25) {
    const double x = x_of(percent / 100.0);
    const bool is_even = percent == 50;
    canvas.line({x, kHead}, {x, bottom}, is_even ? kGrey : kRule, is_even ? 1.4 : 1);
    canvas.text({x, bottom + 16}, fmt::format("{} %", percent), 12, kGrey, TextAnchor::kCentre);
  }
}

void draw_score(Canvas& canvas, const ComparisonScore& score, double top) {
  const double bar = top + 8, middle = bar + kBarHeight / 2;
  canvas.text({kLeft - 12, middle + 4.5}, score.first, 14, kInk, TextAnchor::kRight);
  canvas.text({kRight + 12, middle + 4.5}, score.second, 14, kInk);
  const std::size_t decided = score.first_preferred + score.second_preferred;
  const std::string counts =
      fmt::format("{} : {}, {} the same; p = {:.2g}; {} participant{}", score.first_preferred, score.second_preferred,
                  score.ties, score.p, score.participants, score.participants == 1 ? "" : "s");
  const double half = canvas.text_width(counts, 12) / 2 + 5;
  canvas.fill_rectangle({x_of(0.5) - half, bar + kBarHeight + 5, 2 * half, 17}, kPaper);  // off the scale's lines
  canvas.text({x_of(0.5), bar + kBarHeight + 17}, counts, 12, kGrey, TextAnchor::kCentre);
  if (decided == 0) return;
  Colour first = plot_colour(0), second = plot_colour(1);
  first.alpha = second.alpha = 0.55;
  canvas.fill_rectangle({kLeft, bar, x_of(score.share) - kLeft, kBarHeight}, first);
  canvas.fill_rectangle({x_of(score.share), bar, kRight - x_of(score.share), kBarHeight}, second);
  canvas.line({x_of(score.low), middle}, {x_of(score.high), middle}, kInk, 2);
  for (const double end : {score.low, score.high})
    canvas.line({x_of(end), middle - 5}, {x_of(end), middle + 5}, kInk, 2);
  canvas.fill_circle({x_of(score.share), middle}, 4.5, kInk);
}

}  // namespace

Canvas study_picture(std::span<const ComparisonScore> scores) {
  if (scores.empty()) throw std::invalid_argument("study_picture: no score");
  const double bottom = kHead + kRow * static_cast<double>(scores.size());
  Canvas canvas(kWidth, static_cast<int>(bottom) + kFoot, kPaper);
  canvas.text({kWidth / 2.0, 30}, "Which looks more like a real face?", 18, kInk, TextAnchor::kCentre);
  canvas.text({kWidth / 2.0, 50}, "of the answers that prefer one: the share of the left-hand one, in blue", 12, kGrey,
              TextAnchor::kCentre);
  draw_scale(canvas, bottom);
  for (std::size_t k = 0; k < scores.size(); ++k) draw_score(canvas, scores[k], kHead + kRow * static_cast<double>(k));
  canvas.text({kWidth / 2.0, bottom + 44},
              "Whiskers: Wilson's 95 % interval. p: two-sided sign test over answers, \"the same\" left out.", 12,
              kGrey, TextAnchor::kCentre);
  return canvas;
}

}  // namespace risorius
