#include "daemon/terminal.h"

#include <array>
#include <csignal>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace risorius {
namespace {

class Pipe {
 public:
  Pipe() {
    EXPECT_EQ(::pipe(ends_.data()), 0);
    std::signal(SIGPIPE, SIG_IGN);
  }
  ~Pipe() {
    close_reader();
    ::close(ends_[1]);
  }
  int writer() const { return ends_[1]; }
  void close_reader() {
    if (ends_[0] >= 0) ::close(ends_[0]);
    ends_[0] = -1;
  }
  /// Reads until it has so much, or the writers have gone.
  std::string read(std::size_t size) {
    std::string text;
    std::array<char, 4096> bytes{};
    while (text.size() < size) {
      const ssize_t count = ::read(ends_[0], bytes.data(), std::min(bytes.size(), size - text.size()));
      if (count <= 0) break;
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

TEST(Terminal, ShowsLinesInTheirOrder) {
  Pipe pipe;
  {
    Terminal terminal(pipe.writer());
    terminal.say("first\n");
    terminal.say("second\n");
  }
  EXPECT_EQ(pipe.read(13), "first\nsecond\n");
}

TEST(Terminal, DoesNotWaitForAReaderAndSaysWhatCouldNotBeShown) {
  Pipe pipe;
  const std::string line(99, '-');
  std::string shown;
  std::size_t said = 0;
  Terminal terminal(pipe.writer());
  // Nobody reads: the pipe and what waits fill up, and saying more still returns.
  for (; said < 2 * Terminal::kMostWaitingLines; ++said) terminal.say(line + "\n");
  // Those that wait come first; the next one brings the count.
  while (shown.find("could not be shown") == std::string::npos) {
    terminal.say(line + "\n");
    ++said;
    shown += pipe.read(100);
    ASSERT_LT(shown.size(), 100 * (said + 10));
  }
}

TEST(Terminal, OutlivesAReaderThatHasGone) {
  Pipe pipe;
  pipe.close_reader();
  Terminal terminal(pipe.writer());
  for (int i = 0; i < 10; ++i) terminal.say("nobody reads this\n");
}

TEST(Terminal, OutlivesADiskThatIsFull) {
  const int full = ::open("/dev/full", O_WRONLY);
  ASSERT_GE(full, 0);
  {
    Terminal terminal(full);
    for (int i = 0; i < 10; ++i) terminal.say("no room for this\n");
  }
  ::close(full);
}

}  // namespace
}  // namespace risorius
