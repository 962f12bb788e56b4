// What a receiver of native datagrams can know at best, kept by whoever hands them on (ChaosProxy): of each frame that
// was offered, whether it can be put together from what was forwarded, and in which order it came. Written so that a
// daemon's counters can be compared with it number by number (replay/README.md, "chaos"); it shares the packet decoder
// with the daemon, but none of its bookkeeping.
//
// Assumes of a session that it counts on (no sequence is used again), and that a set id keeps its meaning. Remembers
// kRemembered frames of a session; older ones are settled.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "capture/wire/marker_codec.h"

namespace risorius {

class NativeTruth {
 public:
  static constexpr std::size_t kRemembered = 65536;

  /// A datagram as it came, before anything happened to it; false if it is not a native one.
  bool offered(std::span<const std::byte> datagram);
  /// A copy of it went on, unharmed. In the order of sending.
  void forwarded(std::span<const std::byte> datagram);

  /// By session: {"frames": {...}, "datagrams": {...}}; replay/README.md says what each number is.
  nlohmann::json json() const;

 private:
  struct Set {
    std::size_t count = 0;
    std::bitset<kMaxMarkers> names;
    bool complete = false;
  };
  struct Frame {
    std::size_t count = 0;
    std::bitset<kMaxMarkers> arrived;
    bool whole() const { return arrived.count() == count; }
  };
  struct Counts {
    std::uint64_t offered = 0, whole = 0, lost = 0, incomplete = 0;
    std::uint64_t lost_before_first = 0, late_before_first = 0, after_end = 0;
    std::uint64_t parts_used = 0, parts_repeated = 0, parts_of_incomplete = 0, parts_before_set = 0;
    std::uint64_t set_datagrams = 0, end_datagrams = 0;
    std::map<std::uint64_t, std::uint64_t> overtaken_by;  ///< frames -> whole frames that so many overtook
  };
  struct Session {
    std::map<std::uint32_t, Set> sets;
    std::map<std::uint64_t, Frame> frames;         ///< by sequence
    std::map<std::uint64_t, std::uint64_t> parts;  ///< that were used, of frames that are not whole, by sequence
    std::optional<std::uint64_t> first_whole;      ///< the sequence of the first one to come
    std::optional<std::uint64_t> end;              ///< the last sequence, once it was forwarded
    Counts counts;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> lost;  ///< [first, last], of the settled frames
  };

  void forward(Session& session, const MarkerSetPart& part);
  void forward(Session& session, const MarkerFramePart& part);
  static void note_whole(Session& session, std::uint64_t sequence);
  static void settle(Session& session, std::uint64_t sequence, const Frame& frame);
  static void settle_oldest(Session& session);

  std::map<std::uint32_t, Session> sessions_;
};

}  // namespace risorius
