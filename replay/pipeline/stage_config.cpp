#include "replay/pipeline/stage_config.h"

#include <array>
#include <fstream>
#include <sstream>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::array kDespikeMethods{Choice<DespikeMethod>{"none", DespikeMethod::kNone},
                                     Choice<DespikeMethod>{"displacement", DespikeMethod::kDisplacement},
                                     Choice<DespikeMethod>{"head_frame", DespikeMethod::kHeadFrame}};
constexpr std::array kFillMethods{Choice<FillMethod>{"none", FillMethod::kNone},
                                  Choice<FillMethod>{"hold", FillMethod::kHold},
                                  Choice<FillMethod>{"damped_velocity", FillMethod::kDampedVelocity},
                                  Choice<FillMethod>{"covariance", FillMethod::kCovariance}};

constexpr auto kContinuationChoices = [] {
  std::array<Choice<ContinuationKind>, kContinuationKinds.size()> choices{};
  for (std::size_t i = 0; i < choices.size(); ++i)
    choices[i] = {kContinuationKinds[i].name, kContinuationKinds[i].kind};
  return choices;
}();

// Each key once: name, range, meaning. V is TomlReader or TomlPrinter; O is const for the printer.

template <class V, class O>
void visit_reorder(V& v, O& o) {
  v.number("depth", o.depth, 1, 64, "frames that may wait behind a gap in the sequence");
  v.seconds("timeout_s", o.timeout_ns, 1e-4, 10, "longest wait for a frame that is out of order");
}

template <class V, class O>
void visit_despike(V& v, O& o) {
  v.choice("method", o.method, std::span<const Choice<DespikeMethod>>(kDespikeMethods),
           "displacement is the plain baseline");
  v.number("max_speed_mm_s", o.max_speed_mm_s, 1, 1e6,
           "of a marker: in the world (displacement), about the head (head_frame)");
  v.number("deviation_multiple", o.deviation_multiple, 3, 1000, "times a marker's usual straying");
  v.number("least_deviation_mm", o.least_deviation_mm, 0.01, 1000,
           "nearer than this to the expected place nothing is rejected");
  v.number("most_deviation_mm", o.most_deviation_mm, 0.01, 1000, "farther than this everything is rejected");
  v.seconds("accept_after_s", o.accept_after_ns, 0.01, 60,
            "a marker that stays at its new place so long is taken back");
}

template <class V, class O>
void visit_fill(V& v, O& o) {
  v.choice("method", o.method, std::span<const Choice<FillMethod>>(kFillMethods), "how gaps are filled, causally");
  v.seconds("max_gap_s", o.max_gap_ns, 1e-3, 3600, "a longer gap stays missing from there on");
  v.number("lookahead_frames", o.lookahead_frames, 0, 64,
           "that every frame waits for later ones: so much more latency");
}

template <class V, class O>
void visit_solve(V& v, O& o) {
  v.number("noise_mm", o.noise_mm, 1e-3, 10, "standard deviation of a measured marker, per axis");
  v.number("ridge", o.ridge, 1e-9, 1, "pulls intensities to 0; relative to the mean of the Gram matrix's diagonal");
  v.number("temporal", o.temporal, 0, 1000, "pulls a resting AU towards the last frame; relative as ridge, at 60 Hz");
  v.number("temporal_speed", o.temporal_speed, 1e-3, 1000, "an AU that moves so fast, per s, is pulled half as much");
  v.number("l1", o.l1, 0, 1000,
           "linear cost of intensity times the residuals' variance: 20 if AUs are 0.05 on average");
  v.number("left_right", o.left_right, 0, 1000, "pulls left and right together; relative as ridge");
  v.number("robust_threshold_mm", o.robust_threshold_mm, 0.01, 1000, "a marker that fits worse than this loses weight");
  v.number("robust_iterations", o.robust_iterations, 0, 20, "reweightings per frame; 0 = plain least squares");
  v.number("min_visible_share", o.min_visible_share, 1e-6, 1,
           "of an AU's displacement energy that must be visible to solve it");
  v.number("largest_median_mm", o.largest_median_mm, 0.1, 1000, "a frame whose median marker fits worse has no AUs");
  v.number("pose_steps", o.pose_steps, 0, 20, "most joint steps of pose and AUs; 0: pose of the stabilisers");
}

template <class V, class O, class M>
void visit_continuation(V& v, O& o, M& m) {
  v.choice("model", m.kind, std::span<const Choice<ContinuationKind>>(kContinuationChoices),
           "how the face goes on; learned: a small network; the others are plain baselines");
  v.number("max_rate_hz", o.max_rate_hz, 1, 1000, "predictions per second of capture time");
  auto& d = m.damped_velocity;
  v.number("window_ms", d.window_ms, 1, 1000, "damped_velocity: the last frames that give the velocity");
  v.number("time_constant_ms", d.time_constant_ms, 1, 10000, "damped_velocity: in which the velocity dies away");
  v.number("memory_s", d.memory_s, 0.1, 1000, "damped_velocity: over which own errors are remembered");
}

}  // namespace

void read_stage_tables(TomlReader& reader, StageConfig& stages) {
  PipelineOptions& p = stages.pipeline;
  reader.table("reorder", [&](auto& v) { visit_reorder(v, stages.reorder); });
  reader.table("despike", [&](auto& v) { visit_despike(v, p.despike); });
  reader.table("fill", [&](auto& v) { visit_fill(v, p.fill); });
  reader.table("solve", [&](auto& v) { visit_solve(v, p.solve); });
  reader.table("continuation", [&](auto& v) { visit_continuation(v, p.continuation, p.continuation_model); });
}

void print_stage_tables(TomlPrinter& printer, const StageConfig& stages) {
  const PipelineOptions& p = stages.pipeline;
  printer.table("reorder", [&](auto& v) { visit_reorder(v, stages.reorder); });
  printer.table("despike", [&](auto& v) { visit_despike(v, p.despike); });
  printer.table("fill", [&](auto& v) { visit_fill(v, p.fill); });
  printer.table("solve", [&](auto& v) { visit_solve(v, p.solve); });
  printer.table("continuation", [&](auto& v) { visit_continuation(v, p.continuation, p.continuation_model); });
}

std::string print_stage_config(const StageConfig& stages) {
  TomlPrinter printer;
  print_stage_tables(printer, stages);
  return printer.printed();
}

namespace {

constexpr std::uintmax_t kMostTomlBytes = 1 << 20;
constexpr const char* kTomlFileRemedy = "give the path of a TOML file: a regular file of at most 1 MiB";

}  // namespace

toml::table parse_toml_file(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw UserError(path.string(), "is no regular file", kTomlFileRemedy);
  std::ifstream file(path);
  if (!file) throw UserError(path.string(), "cannot be read", kTomlFileRemedy);
  if (const auto bytes = std::filesystem::file_size(path, error); error || bytes > kMostTomlBytes)
    throw UserError(path.string(), fmt::format("has {} bytes", bytes), kTomlFileRemedy);
  std::ostringstream text;
  text << file.rdbuf();
  return parse_toml(text.str(), path.string());
}

toml::table parse_toml(std::string_view text, const std::string& place) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw UserError(fmt::format("{}, line {}", place, error.source().begin.line), std::string(error.description()),
                    "see the rules of TOML");
  }
}

void throw_if_any(const ConfigProblems& problems, const std::string& place) {
  if (problems.lines().empty()) return;
  std::string message =
      fmt::format("{}: {} problem{}", place, problems.lines().size(), problems.lines().size() == 1 ? "" : "s");
  for (const auto& line : problems.lines()) message += "\n  " + line;
  throw UserError(message);
}

namespace {

/// The tables of one [[source]] override those at the top; its other keys are the daemon's.
void read_source_stages(const toml::array& sources, const std::string& name, StageConfig& stages,
                        ConfigProblems& problems) {
  std::string names;
  for (const toml::node& node : sources) {
    const toml::table& table = *node.as_table();
    const auto own_name = table["name"].value_or(std::string());
    if (name == own_name || (name.empty() && sources.size() == 1)) {
      TomlReader reader(table, "source", problems);
      read_stage_tables(reader, stages);
      return;
    }
    names += (names.empty() ? "" : ", ") + own_name;
  }
  problems.add("source", name.empty() ? "there are several" : "none is called \"" + name + "\"",
               "choose one with --source: " + names);
}

StageConfig stage_config_of(const toml::table& table, const std::string& place, const std::string& source) {
  ConfigProblems problems;
  TomlReader reader(table, "", problems);
  StageConfig stages;
  read_stage_tables(reader, stages);
  for (const char* daemons_own : {"output", "record", "queues", "latency", "shown"}) reader.find(daemons_own);
  if (const toml::node* sources = reader.find("source"); sources != nullptr && sources->is_array_of_tables()) {
    read_source_stages(*sources->as_array(), source, stages, problems);
  }
  reader.refuse_unknown();
  throw_if_any(problems, place);
  return stages;
}

}  // namespace

StageConfig load_stage_config(const std::filesystem::path& path, const std::string& source) {
  return stage_config_of(parse_toml_file(path), path.string(), source);
}

StageConfig parse_stage_config(std::string_view toml, const std::string& place, const std::string& source) {
  return stage_config_of(parse_toml(toml, place), place, source);
}

}  // namespace risorius
