#include "daemon/status.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "capture/frame_words.h"
#include "daemon/counter_table.h"

namespace risorius {
namespace {

nlohmann::json ledger_json(const StageLedger& ledger) {
  return {{"received", ledger.received.value()},
          {"emitted", ledger.emitted.value()},
          {"dropped", ledger.dropped.value()},
          {"refused", ledger.refused.value()},
          {"held", ledger.held.value()}};
}

nlohmann::json datagrams_json(const SourceCounters& counters) {
  nlohmann::json json = ledger_json(counters.datagrams);
  json["kernel_drops"] = counters.kernel_drops.value();
  json["rests"] = counters.rests.value();
  json["foreign"] = counters.foreign.value();
  json["receive_buffer_bytes"] = counters.granted_buffer_bytes.value();
  json["errors"] = nlohmann::json::object();
  for (std::size_t i = 0; i < counters.reasons.size(); ++i) {
    if (counters.refused[i].value() > 0) json["errors"][std::string(counters.reasons[i])] = counters.refused[i].value();
  }
  return json;
}

nlohmann::json rejected_json(const Despiker& despiker) {
  nlohmann::json json = nlohmann::json::object();
  for (const RejectReason reason : {RejectReason::kJump, RejectReason::kDeviation, RejectReason::kNeighbourDistance,
                                    RejectReason::kGhost, RejectReason::kSwap, RejectReason::kNotFinite}) {
    json[std::string(word_of(reason))] = despiker.rejected(reason).value();
  }
  return json;
}

std::uint64_t filled_samples(const GapFiller& filler) {
  std::uint64_t filled = 0;
  for (const RejectReason reason :
       {RejectReason::kNone, RejectReason::kJump, RejectReason::kDeviation, RejectReason::kNeighbourDistance,
        RejectReason::kGhost, RejectReason::kSwap, RejectReason::kNotFinite}) {
    filled += filler.filled(reason).value();
  }
  return filled;
}

nlohmann::json histogram_json(const LatencyHistogram& latency) {
  return {{"p50", latency.quantile_us(0.5)}, {"p99", latency.quantile_us(0.99)}, {"max", latency.max_us()}};
}

nlohmann::json clock_json(const ClockSync& clock) {
  if (!clock.known()) return {{"source", "none"}};
  return {{"source", clock.has_echo() ? "echo" : "arrivals"},
          {"offset_ns", clock.offset_ns()},
          {"skew_ppm", clock.skew_ppm()},
          {"uncertainty_ns", clock.uncertainty_ns()},
          {"leaps", clock.leaps().value()}};
}

}  // namespace

nlohmann::json status_of_stream(const StreamInput& input, const PipelineStream& stream, const Publisher& publisher,
                                std::uint32_t stream_id) {
  const SourceCounters& source = input.source();
  const ReorderCounters& reorder = input.reorder();
  nlohmann::json json{{"endpoint", input.endpoint()},
                      {"rig", stream.actor()->rig.name},
                      {"rig_problem", stream.rig_problem()},
                      {"rig_absent_markers", stream.absent_markers()}};
  json["state"] = input.state();
  json["silences"] = input.watchdog().silences().value();
  json["forecast"] = {{"foreseen", input.forecast().foreseen().value()}, {"missed", input.forecast().missed().value()}};
  json["link"] = {{"state", name_of(source.link.load())},
                  {"reconnects", source.reconnects.value()},
                  {"refused_connections", source.refused_connections.value()}};
  json["clock"] = clock_json(input.clock());
  json["recording_events"] = input.recording_events().value();
  json["tracker"] = nlohmann::json::object();
  for (const SourceExtra& extra : source.extras) json["tracker"][std::string(extra.name)] = extra.counter->value();
  json["datagrams"] = datagrams_json(source);
  json["frames"] = {{"assembled", ledger_json(source.frames)}, {"incomplete", source.incomplete_frames.value()},
                    {"lost", reorder.lost().value()},          {"time_stands", input.time_stands().value()},
                    {"sessions", source.sessions.value()},     {"sets", source.sets_changed.value()}};
  json["reorder"] = ledger_json(reorder.ledger());
  json["reorder"]["duplicates"] = reorder.duplicates().value();
  json["reorder"]["late"] = reorder.late().value();
  json["reorder"]["restarts"] = reorder.restarts().value();
  json["admission"] = ledger_json(input.admission());
  json["admission"]["control_lost"] = input.control_lost().value();
  json["admission"]["hasty_sets"] = input.hasty_sets().value();
  json["despike"] = ledger_json(stream.stages.despiker().ledger());
  json["despike"]["rejected"] = rejected_json(stream.stages.despiker());
  json["fill"] = ledger_json(stream.stages.filler().ledger());
  json["fill"]["lookahead_frames"] = stream.stages.filler().lookahead_frames();
  json["fill"]["filled_markers"] = filled_samples(stream.stages.filler());
  json["fill"]["left_missing_markers"] = stream.stages.filler().left_missing().value();
  json["solve"] = ledger_json(stream.stages.solver().ledger());
  json["refused_frames"] = stream.stages.refused().value();
  json["processed"] = stream.processed.value();
  json["solved"] = stream.by_status[static_cast<std::size_t>(SolverStatus::kConverged)].value() +
                   stream.by_status[static_cast<std::size_t>(SolverStatus::kMapped)].value();
  json["solver"] = nlohmann::json::object();
  for (std::size_t i = 0; i < kSolverStatusCount; ++i)
    json["solver"][std::string(word_of(static_cast<SolverStatus>(i)))] = stream.by_status[i].value();
  const CycleCounters& cycles = stream.cycles;
  json["cycles"] = {{"longest_clean_us", static_cast<double>(cycles.longest_clean_ns.value()) * 1e-3},
                    {"longest_solve_us", static_cast<double>(cycles.longest_solve_ns.value()) * 1e-3},
                    {"longest_us", static_cast<double>(cycles.longest_cycle_ns.value()) * 1e-3},
                    {"over_budget", cycles.over_budget.value()}};
  json["continuations"] = stream.continuations.value();
  json["neutral_captures"] = stream.neutral_captures.value();
  json["neutral_failures"] = stream.neutral_failures.value();
  const StageLatencies& latencies = publisher.latencies(stream_id);
  json["latency_us"] = {{"exposure_to_received", histogram_json(input.exposure_to_received())},
                        {"received_to_cleaned", histogram_json(latencies.received_to_cleaned)},
                        {"cleaned_to_solved", histogram_json(latencies.cleaned_to_solved)},
                        {"solved_to_published", histogram_json(latencies.solved_to_published)},
                        {"received_to_published", histogram_json(latencies.received_to_published)}};
  return json;
}

nlohmann::json status_of_slips(const SlipMonitor& slips) {
  const SlipMonitor::State state = slips.state();
  return {{"count", state.count},
          {"last", state.last},
          {"stabiliser_mm", state.stabiliser_mm},
          {"band_mm", state.band_mm},
          {"neutral_mm", state.neutral_mm}};
}

nlohmann::json status_of_recorder(const Recorder& recorder, const Channel<OutputItem>& channel,
                                  const std::string& folder) {
  nlohmann::json json = status_of_channel(channel);
  json["folder"] = folder;
  json["frames"] = recorder.frames_recorded();
  json["frames_not_written"] = recorder.frames_not_written();
  json["frames_outside"] = recorder.frames_outside();
  json["takes"] = recorder.takes_finished();
  json["problem"] = recorder.problem();
  return json;
}

std::optional<std::uint64_t> count_of(const nlohmann::json& json, const CounterRow& row) {
  std::string path(row.name);
  path.insert(path.begin(), '/');
  std::replace(path.begin(), path.end(), '.', '/');
  const auto pointer = nlohmann::json::json_pointer(path);
  if (!json.contains(pointer)) return std::nullopt;
  const nlohmann::json& value = json.at(pointer);
  return (row.kind == CounterKind::kLossLedger ? value.at("dropped") : value).get<std::uint64_t>();
}

namespace {

/// Every kind of loss that happened, in one line; ledgers lose what they dropped and refused.
std::string losses_of(const nlohmann::json& json, std::span<const CounterRow> rows) {
  std::string text;
  for (const CounterRow& row : rows) {
    if (row.kind != CounterKind::kLoss && row.kind != CounterKind::kLossLedger) continue;
    const std::uint64_t count = count_of(json, row).value_or(0);
    if (count > 0) text += fmt::format("{}{} {} ({})", text.empty() ? "" : ", ", count, row.unit, row.name);
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::string summary_of(const nlohmann::json& status) {
  std::string text;
  for (const auto& [name, s] : status.at("streams").items()) {
    const auto& datagrams = s.at("datagrams");
    const auto& frames = s.at("frames");
    text += fmt::format("{}\n", name);
    text += fmt::format("  datagrams  received {}  used {}  repeated or late {}  refused {}  kernel drops {}\n",
                        datagrams.at("received").dump(), datagrams.at("emitted").dump(), datagrams.at("dropped").dump(),
                        datagrams.at("refused").dump(), datagrams.at("kernel_drops").dump());
    if (!datagrams.at("errors").empty()) text += fmt::format("    refused for {}\n", datagrams.at("errors").dump());
    text += fmt::format("  frames     assembled {}  incomplete {}  lost {}  duplicates {}  late {}\n",
                        frames.at("assembled").at("emitted").dump(), frames.at("incomplete").dump(),
                        frames.at("lost").dump(), s.at("reorder").at("duplicates").dump(),
                        s.at("reorder").at("late").dump());
    text += fmt::format("  admitted   {}  dropped {}\n", s.at("admission").at("emitted").dump(),
                        s.at("admission").at("dropped").dump());
    std::uint64_t rejected = 0;
    for (const auto& [reason, count] : s.at("despike").at("rejected").items()) rejected += count.get<std::uint64_t>();
    text += fmt::format("  repaired   {} markers rejected, {} filled, {} left missing\n", rejected,
                        s.at("fill").at("filled_markers").dump(), s.at("fill").at("left_missing_markers").dump());
    text += fmt::format("  processed  {}  of these solved {}  continuations {}\n", s.at("processed").dump(),
                        s.at("solved").dump(), s.at("continuations").dump());
    const auto& latency = s.at("latency_us").at("received_to_published");
    text += fmt::format("  latency    received to published: median {:.3f} ms, 99 % {:.3f} ms, longest {:.3f} ms\n",
                        latency.at("p50").get<double>() * 1e-3, latency.at("p99").get<double>() * 1e-3,
                        latency.at("max").get<double>() * 1e-3);
    std::string unsolved;
    for (const auto& [status_word, count] : s.at("solver").items()) {
      if (status_word != "converged" && status_word != "mapped" && count.get<std::uint64_t>() > 0)
        unsolved += fmt::format("{}{} {}", unsolved.empty() ? "" : ", ", count.dump(), status_word);
    }
    if (!unsolved.empty()) text += fmt::format("  unsolved   {} (risoriusd --print-counters: solver)\n", unsolved);
    text += fmt::format("  gone       {}\n", losses_of(s, stream_counters()));
    text += fmt::format("  cycles     longest {:.3f} ms, {} over the time between two frames; silent {} times\n",
                        s.at("cycles").at("longest_us").get<double>() * 1e-3, s.at("cycles").at("over_budget").dump(),
                        s.at("silences").dump());
    if (const auto slip = s.at("slip").at("last").get<std::string>(); !slip.empty())
      text += fmt::format("  slip       {}; AUs from then on are in doubt\n", slip);
    for (const char* key : {"rig_problem", "rig_absent_markers"}) {
      if (const auto problem = s.at(key).get<std::string>(); !problem.empty())
        text += fmt::format("  rig        {}\n", problem);
    }
  }
  text += fmt::format("published {} messages, {} frames dropped by the publisher's queue\n",
                      status.at("publish").at("messages").dump(), status.at("publish").at("dropped").dump());
  if (status.contains("record")) {
    const auto& record = status.at("record");
    text += fmt::format("recorded {} frames in {} takes to {}; {} dropped, {} not written\n",
                        record.at("frames").dump(), record.at("takes").dump(), record.at("folder").get<std::string>(),
                        record.at("dropped").dump(), record.at("frames_not_written").dump());
  }
  if (status.contains("session")) {
    const auto& session = status.at("session");
    text += fmt::format(
        "session: {} messages in {} ({} bytes); not recorded: {} datagrams, {} ticks, {} results; "
        "refused by the disk: {}\n",
        session.at("messages").dump(), session.at("file").get<std::string>(), session.at("bytes").dump(),
        session.at("dropped_datagrams").dump(), session.at("dropped_ticks").dump(),
        session.at("dropped_results").dump(), session.at("not_written").dump());
    if (session.at("refused_not_recorded") > 0)
      text += fmt::format("session: of a flood of refused datagrams {} are counted only ({} bytes)\n",
                          session.at("refused_not_recorded").dump(), session.at("refused_bytes_not_recorded").dump());
  }
  return text;
}

}  // namespace risorius
