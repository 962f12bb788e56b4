#include "capture/wire/marker_stream_decoder.h"

#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "capture/errors.h"

namespace risorius {
namespace {

const DecoderOptions& checked(const DecoderOptions& options) {
  if (options.mm_per_unit && !(std::isfinite(*options.mm_per_unit) && *options.mm_per_unit > 0)) {
    throw UserError("mm_per_unit", fmt::format("{} is not a finite number > 0", *options.mm_per_unit),
                    "1 for mm, 10 for cm, 1000 for m");
  }
  if (options.reassembly_frames < 1 || options.reassembly_frames > FrameAssembler::kMemory) {
    throw UserError("reassembly_frames", fmt::format("{} is out of range", options.reassembly_frames),
                    fmt::format("1 to {}", FrameAssembler::kMemory));
  }
  return options;
}

}  // namespace

MarkerStreamDecoder::MarkerStreamDecoder(const DecoderOptions& options)
    : stream_id_(checked(options).stream_id),
      first_book_(options.mm_per_unit, options.axes),
      second_book_(options.mm_per_unit, options.axes),
      assembler_(options.reassembly_frames),
      events_(options.event_capacity),
      counters_(decode_error_names()) {}

void MarkerStreamDecoder::account(const FrameAssembler::Outcome& outcome) noexcept {
  counters_.datagrams.emitted.add(outcome.parts_used);
  counters_.datagrams.dropped.add(outcome.parts_dropped);
  if (outcome.parts_refused > 0) counters_.refuse(outcome.error, outcome.parts_refused);
  counters_.frames.received.add(outcome.frames_opened);
  counters_.frames.dropped.add(outcome.frames_given_up);
  counters_.incomplete_frames.add(outcome.frames_given_up);
  counters_.not_finite_markers.add(outcome.markers_not_finite);
}

void MarkerStreamDecoder::update_held() noexcept {
  counters_.datagrams.held.set(assembler_.held_parts() + living_->held());
  counters_.frames.held.set(assembler_.held_frames() + events_.waiting_frames());
}

bool MarkerStreamDecoder::push(std::span<const std::byte> datagram, std::int64_t receive_time_ns) noexcept {
  if (!ready()) return false;
  counters_.datagrams.received.add();
  NativeMessage message;
  if (const DecodeError error = decode(datagram, message); error != DecodeError::kNone) {
    counters_.refuse(error);
  } else if (const auto* frame = std::get_if<MarkerFramePart>(&message)) {
    take(*frame, receive_time_ns);
  } else if (const auto* set = std::get_if<MarkerSetPart>(&message)) {
    take(*set, receive_time_ns);
  } else if (const auto* end = std::get_if<EndOfStream>(&message)) {
    take(*end);
  }
  update_held();
  return true;
}

void MarkerStreamDecoder::begin_session() noexcept {
  account(assembler_.reset());
  last_end_.reset();
  counters_.sessions.add();
  emit(SourceEventKind::kNewSession);
}

bool MarkerStreamDecoder::is_over(std::int64_t now_ns) const noexcept {
  return !living_->session() || last_end_ || now_ns - last_heard_ns_ >= kSessionHoldNs;
}

bool MarkerStreamDecoder::take_over(std::uint32_t session, std::uint32_t set_id) noexcept {
  if (rival_->session() != session) return false;
  const MarkerSet* set = rival_->find(set_id);
  if (set == nullptr) return false;
  counters_.datagrams.dropped.add(living_->drop_incomplete());
  std::swap(living_, rival_);
  // The parts of a rival's sets were counted as refused when they came. Its other sets come again: senders repeat them.
  living_->drop_incomplete();
  living_->keep_only(set_id);
  begin_session();
  counters_.sets_changed.add();
  emit(SourceEventKind::kMarkerSet).set = set;
  return true;
}

void MarkerStreamDecoder::take(const MarkerSetPart& part, std::int64_t receive_time_ns) noexcept {
  if (living_->session() && *living_->session() != part.session) {
    if (!is_over(receive_time_ns)) {
      rival_->add(part);
      return counters_.refuse(DecodeError::kOtherSession);
    }
    take_over(part.session, part.set_id);
  }
  const MarkerSetBook::Outcome outcome = living_->add(part);
  counters_.datagrams.emitted.add(outcome.used);
  counters_.datagrams.dropped.add(outcome.dropped);
  if (outcome.refused > 0) counters_.refuse(outcome.error, outcome.refused);
  if (living_->session() == part.session) last_heard_ns_ = receive_time_ns;
  if (outcome.new_session) begin_session();
  if (outcome.changed != nullptr) {
    // The parts that have arrived of a frame were placed in the axes of the old set.
    account(assembler_.give_up(outcome.changed->id));
    counters_.sets_changed.add();
    emit(SourceEventKind::kMarkerSet).set = outcome.changed;
  }
}

void MarkerStreamDecoder::take(const MarkerFramePart& part, std::int64_t receive_time_ns) noexcept {
  if (living_->session() && *living_->session() != part.session &&
      !(is_over(receive_time_ns) && take_over(part.session, part.set_id))) {
    return counters_.refuse(DecodeError::kOtherSession);
  }
  const MarkerSet* set = living_->find(part.set_id);
  if (set == nullptr) return counters_.refuse(DecodeError::kUnknownSet);
  if (set->names.size() != part.count) return counters_.refuse(DecodeError::kCountMismatch);
  last_heard_ns_ = receive_time_ns;
  if (last_end_ && part.sequence > last_end_->last_sequence) last_end_.reset();  // it goes on after all
  const FrameAssembler::Outcome outcome = assembler_.add(part, *set);
  account(outcome);
  if (outcome.complete == nullptr) return;
  MarkerFrame& frame = emit(SourceEventKind::kFrame).frame;
  frame = *outcome.complete;
  frame.header.stream_id = stream_id_;
  frame.header.receive_time_ns = receive_time_ns;
}

void MarkerStreamDecoder::take(const EndOfStream& end) noexcept {
  if (living_->session() != end.session) return counters_.refuse(DecodeError::kOtherSession);
  if (last_end_ && last_end_->frames_sent == end.frames_sent && last_end_->last_sequence == end.last_sequence) {
    counters_.datagrams.dropped.add();
    return;
  }
  last_end_ = end;
  counters_.datagrams.emitted.add();
  emit(SourceEventKind::kEndOfStream).end = end;
}

bool MarkerStreamDecoder::pop(SourceEvent& event) noexcept {
  if (!events_.pop(event)) return false;
  if (event.kind == SourceEventKind::kFrame) {
    counters_.frames.emitted.add();
    update_held();
  }
  return true;
}

void MarkerStreamDecoder::flush() noexcept {
  account(assembler_.give_up_all());
  counters_.datagrams.dropped.add(living_->drop_incomplete());
  update_held();
}

}  // namespace risorius
