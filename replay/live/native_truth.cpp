#include "replay/live/native_truth.h"

#include <iterator>
#include <nlohmann/json.hpp>

namespace risorius {
namespace {

template <class Part>
bool has_all(const std::bitset<kMaxMarkers>& present, const Part& part) {
  for (std::size_t i = part.first; i < part.first + part.part_count; ++i) {
    if (!present[i]) return false;
  }
  return true;
}

template <class Part>
void add(std::bitset<kMaxMarkers>& present, const Part& part) {
  for (std::size_t i = part.first; i < part.first + part.part_count; ++i) present.set(i);
}

}  // namespace

bool NativeTruth::offered(std::span<const std::byte> datagram) {
  NativeMessage message;
  if (decode(datagram, message) != DecodeError::kNone) return false;
  if (const auto* part = std::get_if<MarkerFramePart>(&message)) {
    Session& session = sessions_[part->session];
    const auto [frame, is_new] = session.frames.try_emplace(part->sequence);
    if (is_new) {
      frame->second.count = part->count;
      ++session.counts.offered;
    }
    if (session.frames.size() > kRemembered) settle_oldest(session);
  } else if (const auto* set = std::get_if<MarkerSetPart>(&message)) {
    sessions_[set->session].sets[set->set_id].count = set->count;
  }
  return true;
}

void NativeTruth::forwarded(std::span<const std::byte> datagram) {
  NativeMessage message;
  if (decode(datagram, message) != DecodeError::kNone) return;
  if (const auto* part = std::get_if<MarkerFramePart>(&message)) {
    forward(sessions_[part->session], *part);
  } else if (const auto* set = std::get_if<MarkerSetPart>(&message)) {
    forward(sessions_[set->session], *set);
  } else if (const auto* end = std::get_if<EndOfStream>(&message)) {
    Session& session = sessions_[end->session];
    ++session.counts.end_datagrams;
    session.end = end->last_sequence;
  }
}

void NativeTruth::forward(Session& session, const MarkerSetPart& part) {
  ++session.counts.set_datagrams;
  Set& set = session.sets[part.set_id];
  add(set.names, part);
  set.complete = set.complete || set.names.count() == part.count;
}

void NativeTruth::forward(Session& session, const MarkerFramePart& part) {
  Counts& counts = session.counts;
  if (!session.sets[part.set_id].complete) {
    ++counts.parts_before_set;
    return;
  }
  const auto frame = session.frames.find(part.sequence);
  if (frame == session.frames.end() || has_all(frame->second.arrived, part)) {
    ++counts.parts_repeated;
    return;
  }
  add(frame->second.arrived, part);
  ++session.parts[part.sequence];
  if (frame->second.whole()) note_whole(session, part.sequence);
}

void NativeTruth::note_whole(Session& session, std::uint64_t sequence) {
  Counts& counts = session.counts;
  ++counts.whole;
  const auto parts = session.parts.find(sequence);
  counts.parts_used += parts->second;
  session.parts.erase(parts);
  if (!session.first_whole) session.first_whole = sequence;
  if (sequence < *session.first_whole) {
    ++counts.late_before_first;
  } else if (session.end && sequence <= *session.end) {
    ++counts.after_end;
  } else {
    std::uint64_t overtaken_by = 0;
    for (auto later = session.frames.upper_bound(sequence); later != session.frames.end(); ++later)
      overtaken_by += later->second.whole() ? 1 : 0;
    if (overtaken_by > 0) ++counts.overtaken_by[overtaken_by];
  }
}

void NativeTruth::settle(Session& session, std::uint64_t sequence, const Frame& frame) {
  if (frame.whole()) return;
  Counts& counts = session.counts;
  const auto parts = session.parts.find(sequence);
  if (parts != session.parts.end()) {
    ++counts.incomplete;
    counts.parts_of_incomplete += parts->second;
    session.parts.erase(parts);
  }
  ++(session.first_whole && sequence > *session.first_whole ? counts.lost : counts.lost_before_first);
  if (!session.lost.empty() && session.lost.back().second + 1 == sequence) {
    session.lost.back().second = sequence;
  } else {
    session.lost.emplace_back(sequence, sequence);
  }
}

void NativeTruth::settle_oldest(Session& session) {
  const auto oldest = session.frames.begin();
  settle(session, oldest->first, oldest->second);
  session.frames.erase(oldest);
}

nlohmann::json NativeTruth::json() const {
  nlohmann::json sessions = nlohmann::json::object();
  for (const auto& [id, living] : sessions_) {
    Session session = living;
    for (const auto& [sequence, frame] : living.frames) settle(session, sequence, frame);
    const Counts& c = session.counts;
    nlohmann::json overtaken = nlohmann::json::object(), lost = nlohmann::json::array();
    for (const auto& [by, frames] : c.overtaken_by) overtaken[std::to_string(by)] = frames;
    for (const auto& [first, last] : session.lost) lost.push_back({first, last});
    sessions[std::to_string(id)] = {{"frames",
                                     {{"offered", c.offered},
                                      {"whole", c.whole},
                                      {"lost", c.lost},
                                      {"lost_before_first", c.lost_before_first},
                                      {"incomplete", c.incomplete},
                                      {"late_before_first", c.late_before_first},
                                      {"after_end", c.after_end},
                                      {"overtaken_by", overtaken},
                                      {"lost_sequences", lost}}},
                                    {"datagrams",
                                     {{"frame_parts_used", c.parts_used},
                                      {"frame_parts_repeated", c.parts_repeated},
                                      {"frame_parts_of_incomplete", c.parts_of_incomplete},
                                      {"frame_parts_before_set", c.parts_before_set},
                                      {"marker_set", c.set_datagrams},
                                      {"end_of_stream", c.end_datagrams}}}};
  }
  return sessions;
}

}  // namespace risorius
