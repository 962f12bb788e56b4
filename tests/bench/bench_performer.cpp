// Whether the performer moves as people do: bench_performer [FOLDER of alex_rom_3.csv and MySlate_*.csv]. Distributions
// of actions, recorded against performed, by one estimator at 30 Hz (action_statistics.h); fitted on one half of the
// recording and compared with the other; a 1-NN two-sample test of half-second windows; the speed of performing. Writes
// build/bench/performer.png.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>
#include <limits>

#include "bench/bench_report.h"
#include "bench/calibrate_performed.h"
#include "replay/performer/dynamics_fit.h"
#include "replay/performer/performer.h"
#include "replay/performer/wander_fit.h"
#include "replay/picture/plot.h"
#include "replay/takes/arkit_aus.h"
#include "replay/takes/live_link_csv.h"
#include "solve/faces/builtin_face.h"
#include "support/test_data.h"

namespace risorius {
namespace {

constexpr double kGridHz = 30;
constexpr int kTakes = 10;
constexpr std::size_t kSpectrumLines = 75;  // windows of 5 s
constexpr std::uint64_t kSeed = 20260;      // not the seed that the fit simulates with

PreparedSeries recorded(const std::filesystem::path& path, AuSeries* aus = nullptr) {
  const LiveLinkTake take = load_live_link_csv(path);
  AuSeries series = aus_of_shapes(take.shapes, shipped_arkit_table(), JawColumns::kWhole, true);
  if (aus != nullptr) *aus = series;
  return prepare_series(series, take.rate_hz);
}

struct Statistic {
  const char* name;
  const char* unit;
  std::vector<double> ActionDistributions::*values;
};
const Statistic kStatistics[] = {{"peak velocity", "1/s", &ActionDistributions::peak_velocity},
                                 {"duration", "s", &ActionDistributions::duration_s},
                                 {"rest to rest", "s", &ActionDistributions::rest_to_rest_s}};

void print_comparison(const char* title, const ActionDistributions& a, const ActionDistributions& b, const char* of_a,
                      const char* of_b) {
  fmt::print("\n{}: {} actions {}, {} actions {}\n", title, a.duration_s.size(), of_a, b.duration_s.size(), of_b);
  fmt::print("  {:<16} {:>6} {:>10} {:>10} {:>9}\n", "", "", of_a, of_b, "ratio - 1");
  for (const Statistic& statistic : kStatistics) {
    for (const double share : {0.1, 0.5, 0.9}) {
      const double x = quantile_of(a.*statistic.values, share), y = quantile_of(b.*statistic.values, share);
      fmt::print("  {:<16} p{:<5.0f} {:>10.3f} {:>10.3f} {:>+9.3f}\n",
                 fmt::format("{}, {}", statistic.name, statistic.unit), 100 * share, x, y, y / x - 1);
    }
  }
}

/// Half-second windows of a series, not overlapping, as rows of frames x AUs.
struct Windows {
  std::vector<std::vector<double>> values;
  std::vector<double> begin_s;
};
Windows windows_of(const PreparedSeries& series) {
  constexpr std::size_t kFrames = 15;
  Windows windows;
  for (std::size_t f = 0; f + kFrames <= series.rows.size(); f += kFrames) {
    auto& window = windows.values.emplace_back();
    for (std::size_t g = f; g < f + kFrames; ++g)
      window.insert(window.end(), series.rows[g].begin(), series.rows[g].end());
    windows.begin_s.push_back(static_cast<double>(f) / series.rate_hz);
  }
  return windows;
}

/// Share of windows whose nearest neighbour is of their own kind; 0.5 where nobody can tell. Windows of one take that
/// begin within two seconds of each other are never neighbours.
double nearest_neighbour_accuracy(const Windows& a, const Windows& b) {
  constexpr double kApartS = 2;
  const std::size_t count = std::min(a.values.size(), b.values.size());
  std::size_t right = 0;
  const auto nearest = [&](const std::vector<double>& window, double begin_s, const Windows& among, bool same) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count; ++i) {
      if (same && std::abs(among.begin_s[i] - begin_s) < kApartS) continue;
      double sum = 0;
      for (std::size_t j = 0; j < window.size() && sum < least; ++j) {
        const double d = window[j] - among.values[i][j];
        sum += d * d;
      }
      least = std::min(least, sum);
    }
    return least;
  };
  for (std::size_t i = 0; i < count; ++i) {
    right += nearest(a.values[i], a.begin_s[i], a, true) < nearest(a.values[i], a.begin_s[i], b, false);
    right += nearest(b.values[i], b.begin_s[i], b, true) < nearest(b.values[i], b.begin_s[i], a, false);
  }
  return static_cast<double>(right) / static_cast<double>(2 * count);
}

/// Mean over several performances: one alone scatters by a few hundredths.
double accuracy_against_performed(const PreparedSeries& real, const Dynamics& dynamics, ScriptKind kind) {
  constexpr int kPerformances = 5;
  const double seconds = static_cast<double>(real.rows.size()) / kGridHz;
  double sum = 0;
  for (std::uint64_t take = 0; take < kPerformances; ++take) {
    const PreparedSeries performed =
        prepare_series(perform_series(real.names, {kind, seconds, kSeed + take, true, false}, dynamics), kGridHz);
    sum += nearest_neighbour_accuracy(windows_of(real), windows_of(performed));
  }
  return sum / kPerformances;
}

/// Mean density over a band, performed by recorded.
double spectrum_ratio(const RestSpectrum& real, const RestSpectrum& performed, double from_hz, double to_hz) {
  double a = 0, b = 0;
  for (std::size_t i = 0; i < real.frequency_hz.size() && i < performed.density.size(); ++i) {
    if (real.frequency_hz[i] < from_hz || real.frequency_hz[i] >= to_hz) continue;
    a += real.density[i];
    b += performed.density[i];
  }
  return b / a;
}

std::vector<double> absolute(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

/// By the processor's time, which other programs on the machine do not change.
double seconds_per_second(const Rig& rig) {
  PerformerOptions options{.seconds = 120};
  options.script = ScriptKind::kMixed;
  std::vector<double> speeds;
  for (int round = 0; round < 5; ++round) {
    Performance performance(rig, options);
    const auto observed = std::make_unique<MarkerFrame>(), clean = std::make_unique<MarkerFrame>();
    const auto truth = std::make_unique<AuFrame>();
    const std::clock_t begin = std::clock();
    while (performance.next(*observed, *truth, *clean)) {
    }
    speeds.push_back(options.seconds * CLOCKS_PER_SEC / static_cast<double>(std::clock() - begin));
  }
  return quantile_of(speeds, 0.5);
}

/// A few AUs of some seconds, one above the other.
void plot_course(Canvas& canvas, const PictureRectangle& where, const PreparedSeries& series, double from_s,
                 const std::string& title) {
  Plot plot({title, "time, s", "intensity over rest"});
  constexpr double kSeconds = 20;
  std::size_t colour = 0;
  for (const char* name : {"AU1", "AU4L", "AU10L", "AU12L", "AU27", "AU18"}) {
    const auto found = std::find(series.names.begin(), series.names.end(), name);
    if (found == series.names.end()) continue;
    const auto k = static_cast<std::size_t>(found - series.names.begin());
    std::vector<double> x, y;
    for (double t = from_s; t < from_s + kSeconds; t += 1 / series.rate_hz) {
      const auto f = static_cast<std::size_t>(t * series.rate_hz);
      if (f >= series.rows.size()) break;
      x.push_back(t);
      y.push_back(series.rows[f][k]);
    }
    plot.line(x, y, plot_colour(colour++), name);
  }
  plot.limit_y(0, 1.05);
  plot.draw(canvas, where);
}

/// What a face does while an AU rests: spectrum of the intensity, steps of the resting level.
void plot_rest(Canvas& canvas, const PreparedSeries& real, const PreparedSeries& performed) {
  Plot spectrum({"AUs at rest: spectral density, median over AUs", "frequency, Hz", "log10 of 1/Hz"});
  Plot drift({"drift of the rest", "|change over 5 s|", "share"});
  std::size_t colour = 0;
  for (const auto& [series, name] : {std::pair{&real, "recorded"}, {&performed, "performed"}}) {
    RestSpectrum of_series = rest_spectrum(*series, kSpectrumLines);
    for (double& density : of_series.density) density = std::log10(std::max(density, 1e-12));
    spectrum.line(of_series.frequency_hz, of_series.density, plot_colour(colour), name);
    drift.ecdf(absolute(rest_drift_steps(*series)), plot_colour(colour++), name);
  }
  drift.limit_y(0, 1);
  spectrum.draw(canvas, {10, 900, 680, 300});
  drift.draw(canvas, {695, 900, 680, 300});
}

void draw(const PreparedSeries& real, const PreparedSeries& performed, const ActionDistributions& of_real,
          const ActionDistributions& of_performed) {
  Canvas canvas(1380, 1210);
  double x = 10;
  for (const Statistic& statistic : kStatistics) {
    Plot plot({statistic.name, fmt::format("{}, {}", statistic.name, statistic.unit), "share of actions"});
    plot.ecdf(of_real.*statistic.values, plot_colour(0), "recorded");
    plot.ecdf(of_performed.*statistic.values, plot_colour(1), "performed");
    plot.logarithmic_x();
    plot.limit_y(0, 1);
    plot.draw(canvas, {x, 10, 450, 320});
    x += 455;
  }
  plot_course(canvas, {10, 345, 1360, 270}, real, 60, "recorded: range of motion");
  plot_course(canvas, {10, 620, 1360, 270}, performed, 60, "performed: range of motion");
  plot_rest(canvas, real, performed);
  const auto folder = std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench";
  std::filesystem::create_directories(folder);
  canvas.save_png(folder / "performer.png");
  fmt::print("\nwritten: build/bench/performer.png\n");
}

void compare_range_of_motion(const std::filesystem::path& path, bench::BenchReport& report) {
  AuSeries aus;
  const PreparedSeries real = recorded(path, &aus);
  const double seconds = static_cast<double>(real.rows.size()) / kGridHz;
  const PreparedSeries performed =
      prepare_series(perform_range_of_motion(aus.names, shipped_dynamics(), seconds, kSeed), kGridHz);
  const ActionDistributions of_real = distributions_of(find_actions(real));
  const ActionDistributions of_performed =
      performed_distributions(real.names, shipped_dynamics(), seconds, kTakes, kSeed);
  print_comparison("shipped dynamics", of_real, of_performed, "recorded", "performed");
  for (const Statistic& statistic : kStatistics) {
    for (const auto& [name, share] : {std::pair{"median", 0.5}, {"p90", 0.9}}) {
      report.add(
          fmt::format("{}, {}: |performed / real - 1|", statistic.name, name),
          std::abs(quantile_of(of_performed.*statistic.values, share) / quantile_of(of_real.*statistic.values, share) -
                   1));
    }
  }
  report.add("1-NN two-sample accuracy, 0.5 s windows",
             accuracy_against_performed(real, shipped_dynamics(), ScriptKind::kRom));
  const RestSpectrum of_rest = rest_spectrum(real, kSpectrumLines), of_made = rest_spectrum(performed, kSpectrumLines);
  report.add("rest spectrum, 0.2 to 1 Hz: performed / real", spectrum_ratio(of_rest, of_made, 0.2, 1));
  report.add("rest spectrum, 1 to 4 Hz: performed / real", spectrum_ratio(of_rest, of_made, 1, 4));
  report.add("rest spectrum, 4 to 12 Hz: performed / real", spectrum_ratio(of_rest, of_made, 4, 12));
  const std::vector<double> drift = absolute(rest_drift_steps(real)),
                            made_drift = absolute(rest_drift_steps(performed));
  for (const auto& [name, share] : {std::pair{"median", 0.5}, {"p90", 0.9}})
    report.add(fmt::format("rest drift over 5 s, {}: performed / real", name),
               quantile_of(made_drift, share) / quantile_of(drift, share));
  draw(real, performed, of_real, of_performed);

  // Fitted on one half, compared with the other. What the halves differ by among themselves stands beside it.
  const std::size_t half = real.rows.size() / 2;
  const PreparedSeries first = part_of(real, 0, half), second = part_of(real, half, half);
  const Dynamics of_first = fit_dynamics(first);
  const ActionDistributions by_first = performed_distributions(first.names, of_first, 0.5 * seconds, 2 * kTakes, kSeed);
  const ActionDistributions in_first = distributions_of(find_actions(first)),
                            in_second = distributions_of(find_actions(second));
  print_comparison("fitted on the first half, compared with it", in_first, by_first, "recorded", "performed");
  print_comparison("fitted on the first half, compared with the second", in_second, by_first, "recorded", "performed");
  print_comparison("the halves among themselves", in_first, in_second, "first", "second");
  double held_out = 0, halves = 0;
  for (const Statistic& statistic : kStatistics) {
    for (const double share : {0.5, 0.9}) {
      const double truth = quantile_of(in_second.*statistic.values, share);
      held_out = std::max(held_out, std::abs(quantile_of(by_first.*statistic.values, share) / truth - 1));
      halves = std::max(halves, std::abs(quantile_of(in_first.*statistic.values, share) / truth - 1));
    }
  }
  report.add("1-NN, first half against second half, both real",
             nearest_neighbour_accuracy(windows_of(first), windows_of(second)));
  report.add("1-NN, fitted on first half, against that half",
             accuracy_against_performed(first, of_first, ScriptKind::kRom));
  report.add("1-NN, fitted on first half, against second half",
             accuracy_against_performed(second, of_first, ScriptKind::kRom));
  report.add("held-out half: worst |performed / real - 1|", held_out);
  report.add("first half against second: worst |ratio - 1|", halves);
}

/// For orientation only: recorded emotional speech of other people against the speech script.
void compare_speech(const std::filesystem::path& folder, bench::BenchReport& report) {
  ActionDistributions real;
  double as_speech = 0, as_rom = 0, takes = 0;
  std::vector<std::string> names;
  for (const char* take : {"MySlate_161_iPhone_cal.csv", "MySlate_164_iPhone_cal.csv", "MySlate_167_iPhone_cal.csv"}) {
    if (!std::filesystem::exists(folder / take)) continue;
    const PreparedSeries series = recorded(folder / take);
    names = series.names;
    append(real, distributions_of(find_actions(series)));
    as_speech += accuracy_against_performed(series, shipped_dynamics(), ScriptKind::kSpeech);
    as_rom += accuracy_against_performed(series, shipped_dynamics(), ScriptKind::kRom);
    takes += 1;
  }
  if (names.empty()) return;
  report.add("1-NN, unseen people's speech against speech", as_speech / takes);
  report.add("1-NN, unseen people's speech against range of motion", as_rom / takes);
  const AuSeries series = perform_series(names, {ScriptKind::kSpeech, 300, kSeed, true, false}, shipped_dynamics());
  print_comparison("speech, for orientation (never fitted)", real,
                   distributions_of(find_actions(prepare_series(series, kGridHz))), "recorded", "performed");
}

}  // namespace
}  // namespace risorius

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 1 ? std::filesystem::path(argv[1]) : risorius::test::data_folder() / "arkit";
  risorius::bench::BenchReport report("performer");
  if (std::filesystem::exists(folder / "alex_rom_3.csv")) {
    risorius::compare_range_of_motion(folder / "alex_rom_3.csv", report);
    risorius::compare_speech(folder, report);
  } else {
    fmt::print(stderr, "no recordings: set RISORIUS_DATA to the data folder\n");
  }
  report.add("performed seconds per second, 55 markers, 120 Hz", risorius::seconds_per_second(risorius::builtin_rig()));
  const risorius::bench::CalibrationError calibration = risorius::bench::calibrate_performed_takes(0.2);
  fmt::print(stderr, "calibration: worst {}\n", calibration.worst_au);
  report.add("calibrate, 0.2 mm noise: wrong share of the basis energy", calibration.wrong_share);
  report.add("calibrate, the same: worst AU", calibration.worst_share);
  return report.finish();
}
