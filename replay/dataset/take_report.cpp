#include "replay/dataset/take_report.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <utility>

#include "replay/picture/plot.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr Colour kInk{0.15, 0.15, 0.18}, kGrey{0.45, 0.46, 0.5}, kLetterLine{0.86, 0.87, 0.9};
constexpr double kWidth = 1500, kPlotWidth = 1180, kPanelHeight = 118, kQualityHeight = 150, kHead = 84;
constexpr double kShown = 0.3;             // an AU that stays below is named, not drawn
constexpr double kHalfLetter = 0.1;        // letters are 0.2 of the intensity apart
constexpr std::size_t kMostPoints = 1600;  // of a curve: more than pixels
constexpr std::size_t kMostPanels = 40, kMostEpisodes = 60;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> thinned(const std::vector<double>& values) {
  const std::size_t step = values.size() / kMostPoints + 1;
  std::vector<double> result;
  for (std::size_t t = 0; t < values.size(); t += step) result.push_back(values[t]);
  return result;
}

double highest(const std::vector<double>& values) {
  double result = 0;
  for (const double v : values) result = v > result ? v : result;  // NaN is not above
  return result;
}

bool are_halves(const std::string& a, const std::string& b) {
  const auto first = parse_au_name(a), second = parse_au_name(b);
  return first && second && first->number == second->number && first->number != 30 && first->side != second->side;
}

}  // namespace

double letter_confidence(double standard_deviation) noexcept {
  if (!(standard_deviation >= 0)) return 0;
  if (standard_deviation == 0) return 1;
  return std::erf(kHalfLetter / (standard_deviation * std::sqrt(2.0)));
}

TakeReport::TakeReport(const Rig& rig, const MarkerSet& set, std::string title)
    : rig_(rig), title_(std::move(title)), slip_(rig, set), detector_(rig.au_names(), {}) {
  intensity_.resize(rig.au_count());
  deviation_.resize(rig.au_count());
}

void TakeReport::add(const SolvedFrame& frame) {
  slip_.add(frame);
  if (time_s_.empty()) first_ns_ = frame.aus.header.capture_time_ns;
  time_s_.push_back(static_cast<double>(difference_ns(frame.aus.header.capture_time_ns, first_ns_)) * 1e-9);
  sequence_.push_back(frame.aus.header.sequence);
  const bool is_solved = frame.aus.status == SolverStatus::kConverged;
  double filled = 0, observed = 0;
  for (std::size_t m = 0; m < frame.markers.count; ++m) filled += frame.markers.state[m] == MarkerState::kFilled;
  for (std::size_t i = 0; i < rig_.au_count(); ++i) {
    const bool is_seen = is_solved && frame.aus.state[i] == AuState::kObserved;
    observed += is_seen;
    intensity_[i].push_back(is_seen ? frame.aus.intensity[i] : kNaN);
    deviation_[i].push_back(is_seen ? frame.aus.standard_deviation[i] : kNaN);
  }
  residual_mm_.push_back(is_solved ? frame.aus.residual_rms_mm : kNaN);
  filled_share_.push_back(100 * filled / std::max(1.0, static_cast<double>(frame.markers.count)));
  observed_share_.push_back(100 * observed / static_cast<double>(rig_.au_count()));
  Episode episode;
  while (!detector_.push(frame.aus)) {
    while (detector_.pop(episode)) episodes_.push_back(episode);
  }
  while (detector_.pop(episode)) episodes_.push_back(episode);
}

double TakeReport::confidence_of(const Episode& episode) const {
  const auto at = std::ranges::lower_bound(sequence_, episode.apex.frame);
  if (at == sequence_.end()) return 0;
  return letter_confidence(deviation_[episode.column][static_cast<std::size_t>(at - sequence_.begin())]);
}

/// Columns to draw, left and right together.
std::vector<std::vector<std::size_t>> TakeReport::panels() const {
  std::vector<std::vector<std::size_t>> result;
  for (std::size_t i = 0; i < rig_.au_count(); ++i) {
    if (!result.empty() && result.back().size() == 1 && are_halves(rig_.aus[result.back()[0]].name, rig_.aus[i].name)) {
      result.back().push_back(i);
    } else {
      result.push_back({i});
    }
  }
  std::erase_if(result, [&](const auto& columns) {
    return std::ranges::all_of(columns, [&](std::size_t i) { return highest(intensity_[i]) < kShown; });
  });
  if (result.size() > kMostPanels) result.resize(kMostPanels);
  return result;
}

void TakeReport::draw_aus(Canvas& canvas, const std::vector<std::vector<std::size_t>>& panels, double top) const {
  const std::vector<double> time = thinned(time_s_);
  for (std::size_t p = 0; p < panels.size(); ++p) {
    std::string title;
    for (const std::size_t i : panels[p]) title += (title.empty() ? "" : ", ") + rig_.aus[i].name;
    Plot plot({.title = "", .x = "", .y = title});
    plot.limit_y(0, 1.25);
    plot.limit_x(0, std::max(1e-3, time_s_.back()));
    for (const double cut : {0.1, 0.3, 0.5, 0.7, 0.9}) plot.mark_y(cut, kLetterLine);
    for (std::size_t k = 0; k < panels[p].size(); ++k) {
      const std::size_t i = panels[p][k];
      const std::vector<double> x = thinned(intensity_[i]), sd = thinned(deviation_[i]);
      std::vector<double> low, high;
      for (std::size_t t = 0; t < x.size(); ++t) {
        low.push_back(std::max(0.0, x[t] - 2 * sd[t]));
        high.push_back(std::min(1.25, x[t] + 2 * sd[t]));
      }
      Colour band = plot_colour(k);
      band.alpha = 0.5;
      plot.band(time, low, high, band);
      plot.line(time, x, plot_colour(k), panels[p].size() > 1 ? rig_.aus[i].name : "");
    }
    const double y = top + kPanelHeight * static_cast<double>(p);
    plot.draw(canvas, {0, y, kPlotWidth, kPanelHeight});
  }
}

void TakeReport::draw_quality(Canvas& canvas, double top) const {
  const std::vector<double> time = thinned(time_s_);
  Plot residual({.title = "", .x = "", .y = "residual, mm rms"});
  residual.line(time, thinned(residual_mm_), plot_colour(0));
  residual.limit_x(0, std::max(1e-3, time_s_.back()));
  residual.draw(canvas, {0, top, kPlotWidth, kQualityHeight});
  Plot shares({.title = "", .x = "", .y = "%"});
  shares.line(time, thinned(filled_share_), plot_colour(1), "markers filled");
  shares.line(time, thinned(observed_share_), plot_colour(2), "AUs observed");
  shares.limit_x(0, std::max(1e-3, time_s_.back()));
  shares.draw(canvas, {0, top + kQualityHeight, kPlotWidth, kQualityHeight});
  std::vector<double> at, stabiliser, neutral, band;
  for (const DriftSample& sample : slip_.history()) {
    at.push_back(sample.time_s);
    stabiliser.push_back(sample.stabiliser_mm);
    neutral.push_back(sample.neutral_mm);
    band.push_back(std::isnan(sample.neutral_mm) ? kNaN : sample.band_mm);
  }
  Plot slip({.title = "", .x = "time, s", .y = "mm"});
  slip.line(at, stabiliser, plot_colour(0), "stabiliser off its place");
  slip.line(at, neutral, plot_colour(1), "rest off the neutral, rms");
  slip.line(at, band, plot_colour(2), "face against stabilisers");
  slip.limit_x(0, std::max(1e-3, time_s_.back()));
  slip.draw(canvas, {0, top + 2 * kQualityHeight, kPlotWidth, kQualityHeight + 24});
}

void TakeReport::draw_episodes(Canvas& canvas, double top) const {
  const double left = kPlotWidth + 24;
  canvas.text({left, top}, "Strongest episodes", 14, kInk);
  canvas.text({left, top + 18}, "code, apex, chance that the letter holds", 11, kGrey);
  std::vector<Episode> strongest = episodes_;
  std::ranges::stable_sort(strongest, std::greater<>(), &Episode::peak);
  const auto room = static_cast<std::size_t>((canvas.height() - top - 40) / 18);
  for (std::size_t k = 0; k < std::min({strongest.size(), room, kMostEpisodes}); ++k) {
    const Episode& e = strongest[k];
    const double y = top + 42 + 18 * static_cast<double>(k);
    canvas.text({left, y}, facs_code(e, rig_.aus[e.column].name), 12, kInk);
    canvas.text({left + 80, y},
                fmt::format("{:.2f} s", static_cast<double>(difference_ns(e.apex.time_ns, first_ns_)) * 1e-9), 12,
                kGrey);
    canvas.text({left + 170, y}, fmt::format("{:.0f} %", 100 * confidence_of(e)), 12, kGrey);
  }
}

Canvas TakeReport::draw() {
  detector_.flush();
  Episode episode;
  while (detector_.pop(episode)) episodes_.push_back(episode);
  const auto shown = panels();
  const double bottom = kHead + kPanelHeight * static_cast<double>(shown.size());
  Canvas canvas(static_cast<int>(kWidth), static_cast<int>(bottom + 3 * kQualityHeight + 34));
  canvas.text({16, 26}, title_, 18, kInk);
  std::string slips = slip_.slips().empty() ? "no slip found" : "";
  for (const Slip& slip : slip_.slips()) {
    slips +=
        fmt::format("{}{} slipped by {:.1f} mm at {:.1f} s", slips.empty() ? "" : "; ",
                    slip.marker.empty() ? "the head band (all stabilisers)" : slip.marker, slip.moved_mm, slip.time_s);
  }
  canvas.text({16, 48},
              fmt::format("rig {}; {} frames, {:.1f} s; {} episodes; {}", rig_.name, time_s_.size(),
                          time_s_.empty() ? 0 : time_s_.back(), episodes_.size(), slips),
              12, kGrey);
  std::vector<std::string> quiet;
  for (std::size_t i = 0; i < rig_.au_count(); ++i) {
    const std::string& name = rig_.aus[i].name;
    if (std::ranges::any_of(shown, [&](const auto& c) { return std::ranges::find(c, i) != c.end(); })) continue;
    if (i > 0 && !quiet.empty() && quiet.back() == rig_.aus[i - 1].name && are_halves(quiet.back(), name)) {
      quiet.back() = name.substr(0, name.size() - 1);  // both sides
    } else {
      quiet.push_back(name);
    }
  }
  canvas.text(
      {16, 66},
      fmt::format("Intensity with two standard deviations; lines: FACS letters A to E. Below {:.1f} throughout: {}",
                  kShown, quiet.empty() ? "none" : fmt::format("{}", fmt::join(quiet, " "))),
      11, kGrey);
  if (time_s_.empty()) return canvas;
  draw_aus(canvas, shown, kHead);
  draw_quality(canvas, bottom);
  draw_episodes(canvas, kHead + 6);
  return canvas;
}

}  // namespace risorius
