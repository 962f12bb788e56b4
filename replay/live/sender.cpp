#include "replay/live/sender.h"

#include <algorithm>
#include <fmt/format.h>
#include <random>
#include <stdexcept>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {

namespace {

constexpr std::int64_t kFirstRepeatNs = 50'000'000;

const SenderOptions& checked(const SenderOptions& options) {
  if (options.repeat_set_ns < 0) {
    throw UserError("repeat_set_ns", fmt::format("{} is out of range", options.repeat_set_ns), "0 or more");
  }
  return options;
}

}  // namespace

Sender::Sender(const SendTarget& target, const SenderOptions& options)
    : options_(checked(options)),
      session_(options.session != 0 ? options.session : std::random_device()()),
      channel_(target, {.curve = options.curve,
                        .zmq_high_water_mark = options.zmq_high_water_mark,
                        .give_up_after_ns = options.give_up_after_ns}) {}

Sender::~Sender() = default;

bool Sender::send(std::size_t bytes) {
  const bool sent = channel_.send(std::span<const std::byte>(buffer_).first(bytes), statistics_.send_errors);
  statistics_.datagrams += sent ? 1 : 0;
  return sent;
}

void Sender::send_set_in_force() {
  for (std::size_t next = 0; next < set_.names.size();) {
    const EncodedPart part = encode(set_, session_, revision_, next, buffer_);
    send(part.bytes);
    next = part.next;
  }
  set_sent_ns_ = monotonic_now_ns();
}

void Sender::send_marker_set(const MarkerSet& set) {
  if (const auto problems = problems_of(set); !problems.empty()) {
    throw UserError(fmt::format("marker set {}: {}", set.id, fmt::join(problems, "; ")));
  }
  MarkerSet in_mm = set;
  in_mm.mm_per_unit = 1;
  in_mm.axes = Axes();
  // Parts of two definitions must not be taken for one.
  if (!set_.names.empty() && in_mm != set_) ++revision_;
  set_ = std::move(in_mm);
  repeat_set_ns_ = std::min(kFirstRepeatNs, options_.repeat_set_ns);
  send_set_in_force();
}

void Sender::send_frame(const MarkerFrame& frame) {
  if (frame.header.set_id != set_.id || frame.count != set_.names.size() || set_.names.empty()) {
    throw std::invalid_argument(fmt::format("frame {} has {} markers of set {}; the set in force is {} with {}",
                                            frame.header.sequence, frame.count, frame.header.set_id, set_.id,
                                            set_.names.size()));
  }
  if (monotonic_now_ns() - set_sent_ns_ >= repeat_set_ns_) {
    send_set_in_force();
    // Often at first, for a receiver that is just coming up.
    repeat_set_ns_ = std::min(2 * repeat_set_ns_, options_.repeat_set_ns);
  }
  bool whole = true;
  for (std::size_t next = 0; next < frame.count;) {
    const EncodedPart part = encode(frame, session_, next, buffer_);
    whole = send(part.bytes) && whole;
    next = part.next;
  }
  ++frames_offered_;
  last_sequence_ = frame.header.sequence;
  ++(whole ? statistics_.frames : statistics_.frames_not_sent);
}

void Sender::send_end_of_stream() {
  const std::size_t bytes = encode(
      EndOfStream{.session = session_, .frames_sent = frames_offered_, .last_sequence = last_sequence_}, buffer_);
  for (int copy = 0; copy < channel_.copies(); ++copy) send(bytes);
}

}  // namespace risorius
