#include "daemon/notices.h"

#include <array>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

#include "daemon/counter_table.h"
#include "daemon/status.h"

namespace risorius {
namespace {

using Advice = std::pair<std::string_view, std::string_view>;

/// Empty if there is none.
std::string_view advice_on(std::string_view word, std::span<const Advice> advices) {
  for (const auto& [name, advice] : advices) {
    if (name == word) return advice;
  }
  return {};
}

/// Of states worth a line; the others are the way to one of these.
constexpr std::array<Advice, 5> kAdviceOnStates{{
    {"streaming", "frames come"},
    {"stale", "nothing has come for three frame times: is the tracker on, the cable in, the sender alive?"},
    {"connecting", "the tracker does not answer yet: is it on, is the address right, does a firewall block it?"},
    {"waiting", "the tracker answers, but sends no frames: is it live or playing, are there labelled markers?"},
    {"lost", "the connection is gone; trying again"},
}};

constexpr std::string_view kAdviceOnEnd = "the stream has ended; the next one is waited for";

/// Of a solver's status without AUs.
constexpr std::array<Advice, 6> kAdviceOnStatuses{{
    {"not_solved", "the rig does not fit the markers"},
    {"too_few_markers", "occlusions, or stabilisers that disagree: are labels swapped?"},
    {"poor_fit", "is it the right rig, are units and axes as the sender has them?"},
    {"mirrored", "one letter of the source's axes points the wrong way"},
    {"no_face", "the face tracker sees nobody"},
    {"iteration_limit", "the solver did not come to an end: report this"},
}};

/// Datagrams that are of no use, by reason: a whole source may be refused so.
void add_refusals(const std::string& where, const nlohmann::json& stream, std::map<std::string, std::uint64_t>& told,
                  std::vector<std::string>& lines) {
  const nlohmann::json::json_pointer errors("/datagrams/errors");
  if (!stream.contains(errors)) return;
  for (const auto& [reason, count_json] : stream.at(errors).items()) {
    const auto count = count_json.get<std::uint64_t>();
    std::uint64_t& before = told[where + "/refused/" + reason];
    if (count < 2 * before || count == 0) continue;
    before = count;
    lines.push_back(fmt::format("{}: {} datagrams refused: {}: see datagrams.errors of risoriusd --print-counters",
                                where, count, reason));
  }
}

/// What somebody should act on: losses, and peers that were turned away.
bool is_worth_telling(const CounterRow& row) {
  return row.kind == CounterKind::kLoss || row.kind == CounterKind::kLossLedger ||
         row.name.ends_with("refused_connections") || row.name == "connections.refused";
}

void add_losses(const std::string& where, const nlohmann::json& json, std::span<const CounterRow> rows,
                std::map<std::string, std::uint64_t>& told, std::vector<std::string>& lines) {
  for (const CounterRow& row : rows) {
    if (!is_worth_telling(row)) continue;
    const std::uint64_t count = count_of(json, row).value_or(0);
    std::uint64_t& before = told[where + "/" + std::string(row.name)];
    if (count == 0 || count < 2 * before) continue;
    before = count;
    lines.push_back(fmt::format("{}: {} {} {}{}{}", where, row.name, count, row.unit.empty() ? row.meaning : row.unit,
                                row.when_it_rises.empty() ? "" : ": ", row.when_it_rises));
  }
}

}  // namespace

std::string Notices::commonest_status(const nlohmann::json& stream, Stream& before) {
  std::string commonest;
  std::uint64_t most = 0;
  for (const auto& [status, count_json] : stream.at("solver").items()) {
    const auto count = count_json.get<std::uint64_t>();
    const std::uint64_t more = count - std::exchange(before.by_status[status], count);
    if (more > most) {
      most = more;
      commonest = status;
    }
  }
  return commonest;
}

void Notices::update_stream(const std::string& name, const nlohmann::json& stream, std::vector<std::string>& lines) {
  Stream& before = streams_[name];
  const auto state = stream.at("state").get<std::string>();
  if (std::exchange(before.state, state) != state) {
    // Where the link streams on, it is the stream that has ended, as streams do.
    const bool ended =
        state == "waiting" && stream.value(nlohmann::json::json_pointer("/link/state"), std::string()) == "streaming";
    if (const auto advice = ended ? kAdviceOnEnd : advice_on(state, kAdviceOnStates); !advice.empty())
      lines.push_back(fmt::format("{}: {}: {}", name, state, advice));
  }
  const auto problem = stream.at("rig_problem").get<std::string>();
  if (std::exchange(before.rig_problem, problem) != problem && !problem.empty())
    lines.push_back(fmt::format("{}: no AUs: {}", name, problem));
  const auto absent = stream.value("rig_absent_markers", std::string());
  if (std::exchange(before.absent_markers, absent) != absent && !absent.empty())
    lines.push_back(fmt::format("{}: {}; AUs that only they show are not observed", name, absent));

  const std::string status = commonest_status(stream, before);
  if (!status.empty()) {
    const auto advice = advice_on(status, kAdviceOnStatuses);
    const std::string unsolved = advice.empty() ? "" : status;
    if (std::exchange(before.unsolved, unsolved) != unsolved) {
      lines.push_back(unsolved.empty() ? fmt::format("{}: frames have AUs again", name)
                                       : fmt::format("{}: frames without AUs: {}: {}", name, status, advice));
    }
  }
  if (const auto captures = stream.value("neutral_captures", std::uint64_t{0});
      std::exchange(before.neutral_captures, captures) != captures) {
    lines.push_back(fmt::format("{}: neutral taken", name));
  }
  if (const auto failures = stream.value("neutral_failures", std::uint64_t{0});
      std::exchange(before.neutral_failures, failures) != failures) {
    lines.push_back(fmt::format(
        "{}: neutral NOT taken: the face moved or was hidden, or the take ended meanwhile; ask again", name));
  }
  if (stream.contains("slip")) {
    const nlohmann::json& slip = stream.at("slip");
    if (const auto slips = slip.at("count").get<std::uint64_t>(); std::exchange(before.slips, slips) != slips) {
      lines.push_back(fmt::format("{}: {}: AUs from then on are in doubt; press it on and take the neutral anew", name,
                                  slip.at("last").get<std::string>()));
    }
  }
  const nlohmann::json::json_pointer time_stands("/frames/time_stands");
  if (!before.time_stood && stream.contains(time_stands) && stream.at(time_stands) > 0) {
    before.time_stood = true;
    lines.push_back(fmt::format(
        "{}: capture time does not advance: seconds, episodes and fills of these frames are in doubt; let the sender "
        "give each frame the time of its exposure in capture_time_ns, growing from frame to frame",
        name));
  }
  add_refusals(name, stream, told_, lines);
  add_losses(name, stream, stream_counters(), told_, lines);
}

std::vector<std::string> Notices::update(const nlohmann::json& status) {
  std::vector<std::string> lines;
  for (const auto& [name, stream] : status.at("streams").items()) update_stream(name, stream, lines);
  for (const char* where : {"/record/problem", "/session/problem"}) {
    const nlohmann::json::json_pointer pointer(where);
    const auto problem = status.contains(pointer) ? status.at(pointer).get<std::string>() : std::string();
    if (std::exchange(record_problems_[where], problem) != problem && !problem.empty())
      lines.push_back("recording: " + problem);
  }
  add_losses("service", status, service_counters(), told_, lines);
  return lines;
}

}  // namespace risorius
