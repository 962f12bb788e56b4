// Records a session to one MCAP file (replay/session/): what the sources received, what was admitted, what was
// published. Two rings, one from the I/O thread and one from the publisher's, end in a thread of its own, so no frame
// ever waits for the disk: what finds a ring full is not recorded, and counted. Datagrams give way first: the last
// quarter of a ring is for the Ticks, which are the truth. Of what a source refuses a little is recorded, to be looked
// at; the rest of a flood is counted only, so that strangers cannot fill the disk.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <thread>
#include <vector>

#include "capture/counters.h"
#include "capture/wire/raw_tap.h"
#include "daemon/pipeline_items.h"
#include "daemon/record_ring.h"
#include "replay/session/session_writer.h"

namespace risorius {

class SessionRecorder {
 public:
  /// Of each source and second: so many bytes of refused datagrams are recorded, with what the file adds to each.
  static constexpr std::size_t kMostRefusedBytes = 256 * 1024;

  /// `ring_bytes`: of each of the two rings.
  SessionRecorder(std::size_t streams, std::size_t ring_bytes);
  ~SessionRecorder();
  SessionRecorder(const SessionRecorder&) = delete;
  SessionRecorder& operator=(const SessionRecorder&) = delete;

  /// Makes the file and begins. Throws UserError. What was offered before is recorded, too.
  void start(std::filesystem::path path, SessionDescription description);
  /// After both producers ended: writes what is queued and the report, and completes the file.
  void stop();

  // The I/O thread.
  RawTap raw_tap(std::uint32_t stream_id) noexcept { return {&SessionRecorder::receive, this, stream_id}; }
  void admitted(const AdmittedItem& item) noexcept;

  // The publisher's thread. `message` as it was published; of topic markers for kMarkerView, which takes what is due.
  void published(SessionTopic topic, std::uint32_t stream_id, std::span<const char> message,
                 std::int64_t time_ns) noexcept;

  /// For the status (daemon/counter_table.h).
  nlohmann::json status() const;
  /// The first problem of the disk, else what the queues had no room for; empty if everything was recorded.
  std::string problem() const;

 private:
  struct Stream {
    std::uint32_t raw = 0, ticks = 0;          ///< offered; the I/O thread's
    std::uint32_t aus = 0, continuations = 0;  ///< the publisher's
    const MarkerSet* owed_set = nullptr;       ///< whose Tick found no room; the I/O thread's
    std::int64_t second_begin_ns = 0;          ///< in which refused_bytes were recorded; the I/O thread's
    std::size_t refused_bytes = 0;
    Counter refused_not_recorded, refused_bytes_not_recorded;
    ViewDecimator marker_view;
  };

  static void receive(void* self, std::uint32_t stream_id, const RawMessage& message) noexcept;
  static bool has_room_for_refused(Stream& stream, const RawMessage& message) noexcept;
  void run() noexcept;
  McapTexts report() const;
  void drain(RecordRing& ring, std::size_t end) noexcept;

  std::size_t keep_for_ticks_;
  RecordRing received_, results_;
  std::deque<Stream> streams_;
  std::vector<std::string> names_;  ///< by stream
  ByteAppender tick_;
  std::uint32_t statuses_ = 0;
  Counter dropped_datagrams_, dropped_ticks_, dropped_results_;
  std::unique_ptr<SessionWriter> writer_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace risorius
