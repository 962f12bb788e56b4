// The thread that writes what the pipeline solved into a dataset folder: one sub-folder per take, the manifest last.
// Off the live path: if the disk is too slow the channel fills, frames are not recorded, and the loss is counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/channel.h"
#include "daemon/pipeline_items.h"
#include "replay/dataset/take_dataset.h"

namespace risorius {

class Recorder {
 public:
  struct Stream {
    std::string name;
    Rig rig;
    std::string metadata_json;  ///< into every take.json of the stream
  };
  struct Options {
    std::filesystem::path folder;  ///< made here; must not exist yet
    std::vector<Stream> streams;   ///< by stream id
    std::string card_markdown;     ///< README.md of the dataset
    bool follow_tracker = false;   ///< record only while the tracker records
    /// The stream after so many live neutrals, asked when frames solved with that one come; nullopt if it is forgotten.
    std::function<std::optional<Stream>(std::uint32_t stream_id, std::uint64_t neutral)> with_neutral;
  };

  Recorder(Options options, Channel<OutputItem>& results);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Writes what is queued, completes the takes and the manifest, and ends the thread.
  void stop();

  /// In finished takes.
  std::uint64_t frames_recorded() const noexcept { return frames_recorded_.value(); }
  std::uint64_t takes_finished() const noexcept { return takes_finished_.value(); }
  std::uint64_t frames_not_written() const noexcept { return frames_not_written_.value(); }
  /// Frames that came while the tracker did not record, if it is followed.
  std::uint64_t frames_outside() const noexcept { return frames_outside_.value(); }
  /// The first error of the disk, if there was one: the rest of that take is not written. From any thread.
  std::string problem() const;

 private:
  struct StreamState {
    const MarkerSet* markers = nullptr;
    std::unique_ptr<TakeDataset> take;
    int takes = 0;
    std::uint64_t frames = 0;               ///< in the take
    std::uint64_t neutral = 0;              ///< that the stream's rig has
    std::int64_t went_back_ns = INT64_MIN;  ///< receive time of the frame whose time began a take by going back
    bool failed = false;                    ///< until the next take
    bool tracker_records = false;
    std::string tracker_recording;  ///< the tracker's name for it
  };
  void run() noexcept;
  void record(const OutputItem& item) noexcept;
  void record_frame(StreamState& state, const OutputItem& item) noexcept;
  static bool begins_take(StreamState& state, const MarkerFrame& frame) noexcept;
  void take_neutral(StreamState& state, const OutputItem& item);
  void begin_take(StreamState& state, const Stream& stream);
  void finish_take(StreamState& state) noexcept;
  void give_up_take(StreamState& state, const std::string& why) noexcept;
  void note_problem(const std::string& what) noexcept;

  Options options_;
  Channel<OutputItem>& results_;
  std::deque<StreamState> states_;
  Counter frames_recorded_, takes_finished_, frames_not_written_, frames_outside_;
  mutable std::mutex problem_mutex_;
  std::string problem_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace risorius
