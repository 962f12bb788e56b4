// The counters of every part as JSON: what the `status` topic, the control command and the summary at the end show.
// daemon/counter_table.h says what each one is.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/counter_table.h"
#include "daemon/pipeline_thread.h"
#include "daemon/publisher.h"
#include "daemon/recorder.h"
#include "daemon/slip_monitor.h"
#include "daemon/stream_input.h"

namespace risorius {

nlohmann::json status_of_stream(const StreamInput& input, const PipelineStream& stream, const Publisher& publisher,
                                std::uint32_t stream_id);
nlohmann::json status_of_slips(const SlipMonitor& slips);
nlohmann::json status_of_recorder(const Recorder& recorder, const Channel<OutputItem>& channel,
                                  const std::string& folder);

/// What a row's path holds, of a ledger what it dropped; nothing if the status has no such path.
std::optional<std::uint64_t> count_of(const nlohmann::json& json, const CounterRow& row);

template <class T>
nlohmann::json status_of_channel(const Channel<T>& channel) {
  return {{"queued", channel.queue().size()},
          {"high_water", channel.queue().high_water()},
          {"dropped", channel.refused_frames()},
          {"control_lost", channel.refused_control()}};
}

/// The same for people, at the end of a session: what came, what went where, what was lost and why.
std::string summary_of(const nlohmann::json& status);

}  // namespace risorius
