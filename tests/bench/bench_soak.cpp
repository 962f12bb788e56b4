// Hours of streaming: 120 Hz x 100 markers through the daemon with a client that takes everything and reads nothing.
// Memory, descriptors and latency as curves (build/bench/soak.png); the memory's slope by least squares after a
// warm-up.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "bench/bench_report.h"
#include "capture/monotonic_clock.h"
#include "replay/picture/canvas.h"
#include "replay/picture/plot.h"
#include "replay/progress_line.h"
#include "support/test_data.h"
#include "system/closed_loop.h"
#include "system/own_daemon.h"

namespace risorius::bench {
namespace {

constexpr double kRateHz = 120;
constexpr std::size_t kMarkers = 100;
constexpr double kIntervalSeconds = 5;
/// The stalled client has everything that is on its way to it after so long a silence.
constexpr int kDrainedMs = 2000;
/// Until the stalled client's buffers are full and every allocator has seen all that it will: a fifth of the run.
constexpr double kWarmUpShare = 0.2;

struct Sample {
  double minutes = 0, resident_mb = 0, descriptors = 0, p50_ms = 0, p99_ms = 0;
};

std::vector<double> column(const std::vector<Sample>& samples, double Sample::*field) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(sample.*field);
  return values;
}

struct Line {
  double at_0 = 0, slope = 0, slope_error = 0;
};

/// Least squares; the error from the residuals, as if they were independent.
Line fit(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0, xy = 0, squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  Line line;
  line.slope = xy / xx;
  line.at_0 = mean_y - line.slope * mean_x;
  for (std::size_t i = 0; i < x.size(); ++i) squares += std::pow(y[i] - line.at_0 - line.slope * x[i], 2);
  line.slope_error = std::sqrt(squares / (n - 2) / xx);
  return line;
}

void draw(const std::vector<Sample>& samples, double warm_up_minutes, const Line& line) {
  Canvas canvas(900, 900);
  const auto minutes = column(samples, &Sample::minutes);
  canvas.text({12, 22}, fmt::format("soak: {:g} Hz x {} markers, a stalled client", kRateHz, kMarkers), 15);
  const std::vector<double> ends{warm_up_minutes, minutes.back()};
  const std::vector<double> fitted{line.at_0 + line.slope * ends[0] / 60, line.at_0 + line.slope * ends[1] / 60};
  Plot memory({"memory (shaded: warm-up)", "time, min", "resident, MB"});
  memory.span_x(0, warm_up_minutes, {0.92, 0.92, 0.92, 1});
  memory.line(minutes, column(samples, &Sample::resident_mb), plot_colour(0), "resident");
  memory.line(ends, fitted, plot_colour(1), fmt::format("{:.3f} +- {:.3f} MB/h", line.slope, line.slope_error));
  memory.draw(canvas, {10, 40, 880, 280});
  Plot latency({"from sending a frame to its AUs", "time, min", "ms"});
  latency.line(minutes, column(samples, &Sample::p99_ms), plot_colour(1), "p99 of 5 s");
  latency.line(minutes, column(samples, &Sample::p50_ms), plot_colour(0), "p50");
  latency.draw(canvas, {10, 325, 880, 280});
  Plot descriptors({"open descriptors", "time, min", "descriptors"});
  const auto count = column(samples, &Sample::descriptors);
  descriptors.line(minutes, count, plot_colour(2));
  descriptors.limit_y(0, *std::max_element(count.begin(), count.end()) + 5);
  descriptors.draw(canvas, {10, 610, 880, 280});
  canvas.save_png(std::filesystem::path(RISORIUS_SOURCE_DIR) / "build/bench/soak.png");
}

/// Messages of topic au that still come to a client that has read nothing until now.
std::uint64_t drain(zmq::socket_t& client) {
  client.set(zmq::sockopt::rcvtimeo, kDrainedMs);
  std::uint64_t messages = 0;
  for (zmq::message_t part; client.recv(part);) messages += !part.more() ? 0 : part.to_string_view() == "au" ? 1 : 0;
  return messages;
}

int measure(double minutes, bool record) {
  test::OwnDaemon daemon(test::source_table("face"), record);
  zmq::context_t context;
  zmq::socket_t stalled(context, zmq::socket_type::sub);
  for (const char* topic : {"au", "markers", "continuation", "shown"}) stalled.set(zmq::sockopt::subscribe, topic);
  stalled.set(zmq::sockopt::rcvhwm, 1);
  stalled.connect(daemon.running.publish());

  test::ClosedLoop loop(daemon.running, "face", kRateHz, kMarkers);
  ProgressLine progress("soak", "frames");
  std::vector<Sample> samples;
  std::uint64_t unanswered = 0;
  // By the clock: on a busy machine the stream is slower than its rate.
  const std::int64_t begin_ns = monotonic_now_ns();
  const auto elapsed_minutes = [begin_ns] { return static_cast<double>(monotonic_now_ns() - begin_ns) * 1e-9 / 60; };
  while (elapsed_minutes() < minutes) {
    std::vector<double> latency_ms;
    unanswered += loop.run(kIntervalSeconds, latency_ms);
    const test::ProcessUsage usage = daemon.usage();
    samples.push_back({.minutes = elapsed_minutes(),
                       .resident_mb = usage.resident_bytes * 1e-6,
                       .descriptors = static_cast<double>(usage.descriptors),
                       .p50_ms = test::quantile(latency_ms, 0.5),
                       .p99_ms = test::quantile(latency_ms, 0.99)});
    progress.show(loop.sent(), static_cast<std::uint64_t>(minutes * 60 * kRateHz));
  }
  progress.finish(loop.sent());

  const double warm_up_minutes = kWarmUpShare * samples.back().minutes;
  std::vector<double> hours, resident_mb;
  for (const Sample& sample : samples) {
    if (sample.minutes <= warm_up_minutes) continue;
    hours.push_back(sample.minutes / 60);
    resident_mb.push_back(sample.resident_mb);
  }
  const Line line = fit(hours, resident_mb);
  const auto p99_ms = column(samples, &Sample::p99_ms);
  const auto third = static_cast<std::ptrdiff_t>(p99_ms.size() / 3);
  const double first = test::quantile({p99_ms.begin(), p99_ms.begin() + third}, 0.5);
  const double last = test::quantile({p99_ms.end() - third, p99_ms.end()}, 0.5);
  const auto face = daemon.stream("face");
  const std::uint64_t taken = drain(stalled);

  BenchReport report("soak");
  report.add("memory, slope after warm-up", line.slope);
  report.add("memory, standard error of the slope", line.slope_error);
  report.add("memory at the end", samples.back().resident_mb);
  report.add("descriptors gained", samples.back().descriptors - samples.front().descriptors);
  report.add("frames gone", static_cast<double>(test::gone(face)));
  report.add("frames unanswered within 100 ms", static_cast<double>(unanswered));
  report.add("p99, median over intervals", test::quantile(p99_ms, 0.5));
  report.add("p99, last third / first third", last / first);
  // It did stall: what the daemon could not hand over was dropped for it, and for nobody else.
  report.add("stalled client: AU messages that it missed", static_cast<double>(loop.sent() - taken));
  report.add("measured", samples.back().minutes);
  draw(samples, warm_up_minutes, line);
  daemon.running.end();
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

int main(int argc, char** argv) {
  CLI::App app("Streams for long, and watches the daemon's memory, descriptors and latency.");
  double minutes = 10;
  app.add_option("--minutes", minutes, "how long; days are 1440 each")->check(CLI::Range(1.0, 100'000.0));
  bool record = false;
  app.add_flag("--record", record, "with a recording of the session, about 2 GB an hour");
  CLI11_PARSE(app, argc, argv);
  try {
    return risorius::bench::measure(minutes, record);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench soak: {}\n", error.what());
    return 2;
  }
}
