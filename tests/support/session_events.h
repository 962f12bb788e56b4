// What a tracker session says and hands on, for tests without sockets.
#pragma once

#include <string>
#include <vector>

#include "capture/wire/tracker_session.h"

namespace risorius::test {

inline std::vector<SourceEvent> events_of(TrackerSession& session) {
  std::vector<SourceEvent> events;
  for (SourceEvent event; session.pop(event);) events.push_back(event);
  return events;
}

/// One letter an event: N session, S set, F frame, E end, ( and ) recording, A face shapes.
inline std::string kinds_of(const std::vector<SourceEvent>& events) {
  std::string kinds;
  for (const SourceEvent& event : events) kinds += "NSFE()A"[static_cast<int>(event.kind)];
  return kinds;
}

inline std::string kinds_of(TrackerSession& session) { return kinds_of(events_of(session)); }

inline std::vector<std::byte> said_by(TrackerSession& session) {
  const auto bytes = session.outbox().bytes();
  std::vector<std::byte> said(bytes.begin(), bytes.end());
  session.outbox().clear();
  return said;
}

inline bool balanced(const TrackerSession& session) {
  return session.counters().datagrams.balanced() && session.counters().frames.balanced();
}

}  // namespace risorius::test
