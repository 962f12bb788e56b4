// One line on the terminal that says how far long work is: share, rate, time left. On stderr, redrawn at most ten times
// a second; where stderr is no terminal, one line every ten seconds.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

namespace risorius {

class ProgressLine {
 public:
  /// `unit` such as "frames".
  ProgressLine(std::string what, std::string unit);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// From any thread. `of` 0: the end is not known.
  void show(std::uint64_t done, std::uint64_t of);
  /// Ends the line with the total and the rate; once.
  void finish(std::uint64_t done);

 private:
  void draw(std::uint64_t done, std::uint64_t of, bool last);

  std::string what_, unit_;
  std::mutex mutex_;
  std::int64_t begin_ns_, drawn_ns_ = 0;
  bool terminal_, finished_ = false;
};

}  // namespace risorius
