// What every number of the status means: the one table behind the documents (daemon/README.md is checked against it),
// `risoriusd --print-counters`, and the summary's list of losses. A test holds it against a real status, both ways.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace risorius {

enum class CounterKind : unsigned char {
  kText,
  kLedger,      ///< received, emitted, dropped, refused, held
  kLossLedger,  ///< the same; what it dropped is gone
  kGauge,       ///< a present value
  kCount,       ///< grows
  kLoss,        ///< grows, and each one is something that is gone
  kLatency,     ///< p50, p99 and max of a histogram
  kReasons,     ///< a map of reason to count
};

struct CounterRow {
  std::string_view name;  ///< dotted path; those of a stream relative to it
  CounterKind kind;
  std::string_view unit;
  std::string_view meaning;
  std::string_view when_it_rises;  ///< what to do; may be empty
};

/// Under streams.NAME in the status.
std::span<const CounterRow> stream_counters();
/// At the status' top level.
std::span<const CounterRow> service_counters();

/// Both tables as Markdown.
std::string counter_tables_markdown();

}  // namespace risorius
