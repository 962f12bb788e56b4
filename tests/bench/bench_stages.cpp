// Time per stage and frame on the synthetic performer at 60 markers (55 of the built-in rig, five that it does not
// know), with its noise, occlusions and false tracks. Stages are timed in alternating passes over the same frames;
// medians over passes.
#include <algorithm>
#include <fmt/core.h>
#include <functional>
#include <map>
#include <vector>

#include "bench/bench_report.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/marker_stream_decoder.h"
#include "capture/wire/reorder_window.h"
#include "replay/live/messages.h"
#include "replay/performer/performer.h"
#include "replay/pipeline/frame_pipeline.h"
#include "solve/faces/builtin_face.h"

namespace risorius::bench {
namespace {

constexpr std::size_t kMarkers = 60;

struct Recorded {
  MarkerSet set;
  std::vector<MarkerFrame> frames;
};

Recorded perform(double seconds) {
  PerformerTake take(builtin_rig(), PerformerOptions{.rate_hz = 240, .seconds = seconds});
  Recorded recorded{take.info().markers, {}};
  while (recorded.set.names.size() < kMarkers)
    recorded.set.names.push_back(fmt::format("extra{}", recorded.set.names.size()));
  MarkerFrame frame;
  while (take.next(frame)) {
    frame.header.set_id = recorded.set.id;
    for (std::uint32_t m = frame.count; m < kMarkers; ++m) {
      frame.state[m] = frame.state[m - 5];
      frame.position_mm[m] = frame.position_mm[m - 5];
      frame.position_mm[m].z += 6;  // beside its model, as an extra marker on the face would be
    }
    frame.count = kMarkers;
    recorded.frames.push_back(frame);
  }
  return recorded;
}

/// Nanoseconds that `work` takes for the whole take.
double timed(const std::function<void()>& work) {
  const std::int64_t begin = monotonic_now_ns();
  work();
  return static_cast<double>(monotonic_now_ns() - begin);
}

template <class S, class In, class Out>
void pass_through(S& stage, const std::vector<In>& in, std::vector<Out>& out) {
  out.clear();
  Out result;
  for (const In& frame : in) {
    while (!stage.push(frame)) {
      while (stage.pop(result)) out.push_back(result);
    }
    while (stage.pop(result)) out.push_back(result);
  }
  stage.flush();
  while (stage.pop(result)) out.push_back(result);
}

struct Times {
  std::map<std::string, std::vector<double>> ns_per_frame;
  void add(const std::string& stage, double ns, std::size_t frames) {
    ns_per_frame[stage].push_back(ns / static_cast<double>(frames));
  }
  double median_us(const std::string& stage) {
    auto& values = ns_per_frame.at(stage);
    std::ranges::sort(values);
    return values[values.size() / 2] * 1e-3;
  }
};

void time_decoding(const Recorded& recorded, Times& times) {
  std::vector<DatagramBuffer> datagrams(recorded.frames.size());
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < recorded.frames.size(); ++i)
    sizes.push_back(encode(recorded.frames[i], 1, 0, datagrams[i]).bytes);
  MarkerStreamDecoder decoder;
  SourceEvent event;
  DatagramBuffer set;
  decoder.push(std::span<const std::byte>(set).first(encode(recorded.set, 1, 0, 0, set).bytes), 0);
  const double ns = timed([&] {
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      decoder.push(std::span<const std::byte>(datagrams[i]).first(sizes[i]), 0);
      while (decoder.pop(event)) {
      }
    }
  });
  times.add("decode", ns, datagrams.size());
}

void time_messages(const std::vector<AuFrame>& aus, const std::vector<MarkerFrame>& markers, const Recorded& recorded,
                   const std::vector<std::string>& au_names, Times& times) {
  MessageBuffer buffer;
  const MessageContext au_context{.stream = "face", .names = au_names},
      marker_context{.stream = "face", .names = recorded.set.names};
  times.add("encode AU message", timed([&] {
              for (const auto& frame : aus) encode_aus(frame, au_context, buffer);
            }),
            aus.size());
  times.add("encode marker message", timed([&] {
              for (const auto& frame : markers) encode_markers(frame, marker_context, buffer);
            }),
            markers.size());
}

/// The filler leans on the despiker's head pose and statistics, so they go frame by frame; despike is timed alone, and
/// fill is what both take beyond it.
void time_repair(const std::vector<MarkerFrame>& ordered, const MarkerSet& set, const PipelineOptions& options,
                 std::vector<MarkerFrame>& despiked, std::vector<MarkerFrame>& filled, Times& times) {
  Despiker alone(options.despike), despiker(options.despike);
  GapFiller filler(options.fill);
  alone.use_marker_set(set);
  despiker.use_marker_set(set);
  filler.use_marker_set(set);
  const double despike_ns = timed([&] { pass_through(alone, ordered, despiked); });
  filled.clear();
  MarkerFrame between;
  const double both_ns = timed([&] {
    for (const MarkerFrame& frame : ordered) {
      despiker.push(frame);
      while (despiker.pop(between)) filler.push(between, despiker);
      while (filler.pop(between)) filled.push_back(between);
    }
  });
  times.add("despike", despike_ns, ordered.size());
  times.add("fill", both_ns - despike_ns, ordered.size());
}

void time_pass(const Recorded& recorded, const Rig& rig, Times& times) {
  const std::size_t count = recorded.frames.size();
  const PipelineOptions options;
  std::vector<MarkerFrame> ordered, despiked, filled;
  std::vector<AuFrame> solved;
  for (auto* frames : {&ordered, &despiked, &filled}) frames->reserve(count);
  solved.reserve(count);

  time_decoding(recorded, times);
  ReorderWindow reorder;
  times.add("reorder", timed([&] { pass_through(reorder, recorded.frames, ordered); }), count);
  FramePipeline stages(options, rig);
  stages.use_marker_set(recorded.set);
  time_repair(ordered, recorded.set, options, despiked, filled, times);
  AuSolver solver(rig, options.solve);
  solver.use_marker_set(recorded.set);
  times.add("head pose + AU solve", timed([&] { pass_through(solver, filled, solved); }), count);
  Continuation continuation;
  times.add("continue", timed([&] {
              for (const auto& frame : solved) stages.continue_from(frame, continuation);
            }),
            count);
  time_messages(solved, filled, recorded, rig.au_names(), times);

  FramePipeline whole(options, rig);
  whole.use_marker_set(recorded.set);
  SolvedFrame out;
  times.add("whole chain", timed([&] {
              for (const auto& frame : ordered) {
                whole.push(frame);
                while (whole.pop(out)) whole.continue_from(out.aus, continuation);
              }
            }),
            count);
}

int measure(double seconds, int passes) {
  const Recorded recorded = perform(seconds);
  const Rig rig = builtin_rig();
  Times times;
  for (int pass = 0; pass < passes; ++pass) {
    time_pass(recorded, rig, times);
    fmt::print(stderr, "\rpass {} of {} ", pass + 1, passes);
  }
  fmt::print(stderr, "\n");
  BenchReport report("stages");
  for (const auto& [stage, values] : times.ns_per_frame) report.add(stage, times.median_us(stage));
  report.add("despike + fill", 1e6 / (times.median_us("despike") + times.median_us("fill")));
  report.add("share of a 240 Hz frame", 100 * times.median_us("whole chain") * 240e-6);
  return report.finish();
}

}  // namespace
}  // namespace risorius::bench

// bench_stages [SECONDS of performance, 25] [PASSES, 5]
int main(int argc, char** argv) {
  try {
    return risorius::bench::measure(argc > 1 ? std::atof(argv[1]) : 25, argc > 2 ? std::atoi(argv[2]) : 5);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench stages: {}\n", error.what());
    return 1;
  }
}
