#include "daemon/counter_table.h"

#include <array>
#include <fmt/format.h>

namespace risorius {
namespace {

using enum CounterKind;

constexpr auto kStreamCounters = std::to_array<CounterRow>({
    {"endpoint", kText, "", "where senders can send, or what we are connected to", ""},
    {"state", kText, "",
     "streaming; stale: nothing came for three frame times; waiting: the stream has ended; else the link's state. A "
     "change is published at once",
     "stale: is the tracker on, the cable in, the sender alive?"},
    {"silences", kCount, "", "how often the stream went stale", "a network or a sender that pauses"},
    {"forecast.foreseen", kCount, "frames",
     "that came when they were expected, the threads awake (`[latency] awake_share`)", ""},
    {"forecast.missed", kCount, "frames", "that came before or after that",
     "frames come irregularly, and take some 0.1 ms longer: a busy network or sender"},
    {"link.state", kText, "",
     "listening (nothing has come), connecting, waiting (connected, no frames), streaming, lost",
     "connecting, waiting: is the tracker on, and does it stream?"},
    {"link.reconnects", kCount, "", "how often the connection was lost and made again", "the network, or the tracker"},
    {"link.refused_connections", kCount, "tries", "zmq+tcp with `curve_key`: of senders without the right key",
     "a sender has the wrong key, or its .key file is not in `curve_clients`"},
    {"clock.source", kText, "",
     "what the offset comes from: echo (shortest round trips), arrivals (their lower envelope), none", ""},
    {"clock.offset_ns", kGauge, "ns", "our clock minus the tracker's", ""},
    {"clock.skew_ppm", kGauge, "ppm", "by how much our clock runs faster than the tracker's",
     "hundreds: one of the clocks is bad; hundreds of thousands: a take played at another pace"},
    {"clock.uncertainty_ns", kGauge, "ns", "half the shortest round trip; 0 with arrivals, whose delay nobody knows",
     ""},
    {"clock.leaps", kCount, "", "how often the tracker's clock leapt and was learnt anew", "somebody sets the clock"},
    {"tracker", kReasons, "",
     "what only some protocols count, in the protocol's own words (NatNet, QTM, Vicon, Live Link Face)",
     "unlabelled_markers: label the trajectories; skipped or dropped frames: the tracker's machine or network; "
     "frames_without_face: the phone sees nobody; impossible_timecodes: set `natnet_timecode` to the generator's rate"},
    {"recording_events", kCount, "", "starts and stops of the tracker's own recording",
     "recorded by them if `[record] follow = \"tracker\"`"},
    {"datagrams", kLedger, "datagrams", "ZeroMQ: messages; TCP: packets", ""},
    {"datagrams.kernel_drops", kLoss, "datagrams",
     "that the kernel threw away because our socket's buffer was full (SO_RXQ_OVFL)",
     "the machine is overloaded, or raise `receive_buffer_bytes` and net.core.rmem_max"},
    {"datagrams.receive_buffer_bytes", kGauge, "bytes", "SO_RCVBUF as the kernel granted it", ""},
    {"datagrams.rests", kCount, "",
     "UDP: turns with nothing but refused or repeated datagrams, after which the source waits, so that others get "
     "theirs",
     "a flood on this port: see `datagrams.errors`"},
    {"datagrams.foreign", kCount, "datagrams", "from another host than the tracker; not looked at",
     "something else sends to our port"},
    {"datagrams.errors", kReasons, "datagrams", "refused, by reason",
     "bad_magic, bad_checksum, version: something else sends to this port; too_short, too_long, bad_length, bad_type, "
     "bad_count: not laid out as it says itself (capture/README.md); bad_value: a rate or unit that is no number, or "
     "below "
     "0; bad_set: a marker set with a name twice or empty, or a rate beyond 100 kHz; unknown_set: frames before their "
     "marker set, or whose set was refused; count_mismatch: frame and set differ; other_session: two senders share "
     "this "
     "port, and the first keeps it until it ends or falls silent; other_device: of another phone; leap: its clock "
     "leapt; "
     "too_many_sets: 64 in force at once, or 4096 since risoriusd started: start it again"},
    {"frames.assembled", kLedger, "frames", "put together from datagrams", ""},
    {"frames.incomplete", kLoss, "frames", "given up because a part of them was lost", "the network loses datagrams"},
    {"frames.lost", kLoss, "frames", "that never came, by their sequence numbers", "the network, or the sender"},
    {"frames.time_stands", kCount, "frames",
     "whose capture time is not after that of the one before; solved, published and recorded in the order of their "
     "numbers",
     "capture_time_ns must grow from frame to frame: is the sender's clock set, does it state its frames' times?"},
    {"frames.sessions", kCount, "", "runs of the sender", "it restarts"},
    {"frames.sets", kCount, "", "marker sets described", ""},
    {"reorder", kLedger, "frames", "of the window that puts them in order", ""},
    {"reorder.duplicates", kCount, "frames", "that came twice; a part of its dropped", "a network with two ways"},
    {"reorder.late", kLoss, "frames", "that came after their place was given up; a part of its dropped",
     "raise `[reorder] timeout_s`"},
    {"reorder.restarts", kCount, "", "how often the sequence began anew", "the sender restarts"},
    {"admission", kLossLedger, "frames", "into the pipeline's queue; dropped: it was full",
     "dropped: the machine is overloaded; `[queues] admission`"},
    {"admission.hasty_sets", kLoss, "frames",
     "dropped because their marker set followed too many others: 16 at once, then two a second",
     "the sender changes between sets all the time"},
    {"admission.control_lost", kLoss, "items", "marker sets and ends of streams that found the queue full; must be 0",
     "the machine is overloaded"},
    {"despike", kLedger, "frames", "0 for face shapes, which enter after the solve", ""},
    {"despike.rejected", kReasons, "marker samples", "taken for false, by reason",
     "false tracks: see the camera set-up"},
    {"fill", kLedger, "frames", "", ""},
    {"fill.lookahead_frames", kGauge, "frames", "that every frame waits for later ones; in latency_us with the rest",
     "`[fill] lookahead_frames`"},
    {"fill.filled_markers", kCount, "marker samples", "missing ones that were filled", "occlusions"},
    {"fill.left_missing_markers", kCount, "marker samples", "missing ones in gaps too long to fill",
     "occlusions; `[fill] max_gap_s`"},
    {"solve", kLedger, "frames", "refused: the frame is not of the set in use", ""},
    {"refused_frames", kLoss, "frames", "admitted, but not of the marker set in use", ""},
    {"processed", kCount, "frames", "handed on to publisher and recorder", ""},
    {"solved", kCount, "frames", "of the processed, those that have AUs, solved or mapped from face shapes",
     "behind `processed`: see `solver`"},
    {"solver", kReasons, "frames", "processed, by the solver's status",
     "not_solved: see `rig_problem`; too_few_markers: occlusions, or stabilisers that disagree (labels swapped?); "
     "poor_fit: wrong rig, units or axes; mirrored: one "
     "letter "
     "of the axes points the wrong way; no_face: the face tracker saw nobody"},
    {"rig", kText, "", "the rig in use", ""},
    {"rig_problem", kText, "", "why the rig does not fit the markers; empty if it does",
     "fit a rig to this marker set: `risorius rig fit`"},
    {"rig_absent_markers", kText, "", "which of the rig's markers the marker set lacks; empty if none",
     "AUs that only they show are not observed: fit a rig to this marker set, or correct the names"},
    {"continuations", kCount, "predictions", "made", ""},
    {"neutral_captures", kCount, "", "live neutrals taken", ""},
    {"neutral_failures", kCount, "", "live neutrals that were asked for and not taken; the old one stays",
     "the face moved by more than 4 mm rms, hid its stabilisers, or the take ended meanwhile: ask again"},
    {"shown.messages", kCount, "messages", "of the topic `shown`", ""},
    {"shown.predicted", kCount, "messages", "of these, not the frame's own values: bridges, targets and ways back",
     "drop-outs: frames do not come, or have no face"},
    {"shown.targets", kCount, "", "live targets that were asked for", ""},
    {"slip.count", kCount, "", "stabilisers, or the head band, that came off their places",
     "AUs from then on are in doubt: press it on, fit or take the neutral anew"},
    {"slip.last", kText, "", "the last of them", ""},
    {"slip.stabiliser_mm", kGauge, "mm", "the largest lasting change of a stabiliser against the others", ""},
    {"slip.band_mm", kGauge, "mm", "of the whole face against the stabilisers", ""},
    {"slip.neutral_mm", kGauge, "mm", "rms over markers: the face at rest against the neutral; 0 before it was at rest",
     "the neutral drifts: take it anew"},
    {"cycles.longest_clean_us", kGauge, "us", "longest despike and fill of a frame", ""},
    {"cycles.longest_solve_us", kGauge, "us", "longest solve of a frame", ""},
    {"cycles.longest_us", kGauge, "us", "longest work on a frame, learning and continuation included", ""},
    {"cycles.over_budget", kCount, "frames", "whose work took longer than the time between two frames",
     "the machine is too slow for this rate, or busy"},
    {"latency_us.exposure_to_received", kLatency, "us",
     "from the tracker's exposure, by its clock, to our receive call; without an echo: above the shortest such time",
     ""},
    {"latency_us.received_to_cleaned", kLatency, "us", "queue, despike, fill", ""},
    {"latency_us.cleaned_to_solved", kLatency, "us", "head pose and AUs", ""},
    {"latency_us.solved_to_published", kLatency, "us", "queue, encoding, handing to ZeroMQ", ""},
    {"latency_us.received_to_published", kLatency, "us", "all that the daemon adds", ""},
});

constexpr auto kServiceCounters = std::to_array<CounterRow>({
    {"version", kGauge, "", "of this table: 1", ""},
    {"risorius", kText, "", "the program's version", ""},
    {"instruction_set", kText, "", "that it was built for", ""},
    {"admission.queued", kGauge, "items", "in the queue to the pipeline", ""},
    {"admission.high_water", kGauge, "items", "the most there ever were", ""},
    {"admission.dropped", kLoss, "frames", "that found it full", "the machine is overloaded"},
    {"admission.control_lost", kLoss, "items", "control items that found it full; must be 0", ""},
    {"publish.queued", kGauge, "items", "in the queue to the publisher", ""},
    {"publish.high_water", kGauge, "items", "the most there ever were", ""},
    {"publish.dropped", kLoss, "frames", "solved, but not published", "the machine is overloaded"},
    {"publish.control_lost", kLoss, "items", "must be 0", ""},
    {"publish.messages", kCount, "messages", "handed to ZeroMQ", ""},
    {"continuations.queued", kGauge, "predictions", "in the queue to the publisher", ""},
    {"continuations.high_water", kGauge, "predictions", "the most there ever were", ""},
    {"continuations.dropped", kLoss, "predictions", "not published", "the machine is overloaded"},
    {"continuations.control_lost", kLoss, "items", "must be 0", ""},
    {"control.refused", kCount, "requests", "that were no known command", ""},
    {"connections.refused", kCount, "tries", "[output] with `curve_key`: of clients without the right key",
     "a client has the wrong key, or its .key file is not in `curve_clients`"},
    {"record.folder", kText, "", "the dataset", ""},
    {"record.problem", kText, "", "the disk's first error", "the disk: full, gone, or not to be written"},
    {"record.queued", kGauge, "items", "in the queue to the recorder", ""},
    {"record.high_water", kGauge, "items", "the most there ever were", ""},
    {"record.dropped", kLoss, "frames", "solved, but not recorded: the queue was full", "the disk is too slow"},
    {"record.control_lost", kLoss, "items", "must be 0", ""},
    {"record.frames", kCount, "frames", "in finished takes", ""},
    {"record.frames_not_written", kLoss, "frames", "that the disk or a change of set did not let in",
     "see `record.problem`"},
    {"record.frames_outside", kCount, "frames", "that came while the tracker did not record (`follow = \"tracker\"`)",
     ""},
    {"record.takes", kCount, "takes", "finished", ""},
    {"session.file", kText, "", "the session's MCAP file", ""},
    {"session.problem", kText, "", "the disk's first error with it", "the disk: full, gone, or not to be written"},
    {"session.bytes", kGauge, "bytes", "of the file", ""},
    {"session.messages", kCount, "messages", "on the disk", ""},
    {"session.not_written", kLoss, "messages", "that the disk refused", "see `session.problem`"},
    {"session.dropped_datagrams", kLoss, "datagrams", "received, but not recorded: the queue was full",
     "the disk is too slow, or a flood; `[queues] session_mib`"},
    {"session.dropped_ticks", kLoss, "items", "admitted, but not recorded: the queue was full",
     "the disk is too slow; `[queues] session_mib`"},
    {"session.dropped_results", kLoss, "messages", "published, but not recorded: the queue was full",
     "the disk is too slow; `[queues] session_mib`"},
    {"session.refused_not_recorded", kCount, "datagrams",
     "refused, and beyond the 256 KiB of them that are recorded of each source and second",
     "a flood: who sends to this port?"},
    {"session.refused_bytes_not_recorded", kCount, "bytes", "of those", ""},
    {"session.queued_bytes", kGauge, "bytes", "in the two queues to the file", ""},
    {"session.high_water_bytes", kGauge, "bytes", "the most there ever were in them", ""},
});

std::string_view word_of(CounterKind kind) {
  switch (kind) {
    case kText:
      return "text";
    case kLedger:
      return "ledger";
    case kLossLedger:
      return "ledger, dropped is **loss**";
    case kGauge:
      return "gauge";
    case kCount:
      return "count";
    case kLoss:
      return "**loss**";
    case kLatency:
      return "p50, p99, max";
    case kReasons:
      return "by reason";
  }
  return "";
}

void append_table(std::span<const CounterRow> rows, std::string& text) {
  text += "| name | kind | unit | meaning | when it rises |\n|---|---|---|---|---|\n";
  for (const CounterRow& row : rows) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.name, word_of(row.kind), row.unit, row.meaning,
                        row.when_it_rises);
  }
}

}  // namespace

std::span<const CounterRow> stream_counters() { return kStreamCounters; }
std::span<const CounterRow> service_counters() { return kServiceCounters; }

std::string counter_tables_markdown() {
  std::string text = "Of each stream (`streams.NAME`):\n\n";
  append_table(kStreamCounters, text);
  text += "\nOf the service:\n\n";
  append_table(kServiceCounters, text);
  return text;
}

}  // namespace risorius
