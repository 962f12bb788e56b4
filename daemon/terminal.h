// Lines for whoever looks at the terminal, written by a thread of its own: a terminal that is paused, a pipe whose
// reader has gone or a log on a full disk never hold up or end the service. What cannot be shown is counted and said
// when lines can be shown again. Whoever uses it ignores SIGPIPE.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace risorius {

class Terminal {
 public:
  static constexpr std::size_t kMostWaitingLines = 1000;  ///< beyond: the newest are not shown

  /// `descriptor` stays open, and stays the caller's.
  explicit Terminal(int descriptor);
  /// Shows what waits, for at most 2 s.
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// From any thread; never blocks. `text` gets its line ends from the caller.
  void say(std::string_view text);

 private:
  void run() noexcept;
  /// False if it was not written: the reader has gone, the disk is full, or the end came.
  bool write(std::string_view text) noexcept;
  bool wait_until_writable() noexcept;
  bool time_is_up();

  int descriptor_;
  std::mutex mutex_;
  std::condition_variable wakes_;
  std::deque<std::string> lines_;
  std::uint64_t not_shown_ = 0;
  bool stopping_ = false;
  std::int64_t deadline_ns_ = 0;  ///< once stopping
  std::thread thread_;
};

}  // namespace risorius
