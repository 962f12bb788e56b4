#include "daemon/terminal.h"

#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>
#include <utility>

#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

constexpr std::int64_t kPatienceAtTheEndNs = 2'000'000'000;
constexpr int kLookMs = 50;
/// A pipe that says it is writable takes so much (PIPE_BUF) without blocking.
constexpr std::size_t kAtOnce = 4096;

}  // namespace

Terminal::Terminal(int descriptor) : descriptor_(descriptor), thread_([this] { run(); }) {}

Terminal::~Terminal() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
    deadline_ns_ = monotonic_now_ns() + kPatienceAtTheEndNs;
  }
  wakes_.notify_one();
  thread_.join();
}

void Terminal::say(std::string_view text) {
  {
    const std::scoped_lock lock(mutex_);
    if (lines_.size() >= kMostWaitingLines) {
      ++not_shown_;
      return;
    }
    lines_.emplace_back(text);
  }
  wakes_.notify_one();
}

void Terminal::run() noexcept {
  std::unique_lock lock(mutex_);
  while (true) {
    wakes_.wait(lock, [this] { return stopping_ || !lines_.empty(); });
    if (lines_.empty()) return;
    const std::string text = std::move(lines_.front());
    lines_.pop_front();
    const std::uint64_t missed = not_shown_;
    lock.unlock();
    bool shown = missed == 0 || write(fmt::format("({} lines before this could not be shown)\n", missed));
    const bool told = shown;
    shown = shown && write(text);
    lock.lock();
    if (told) not_shown_ -= missed;
    if (!shown) ++not_shown_;
  }
}

bool Terminal::time_is_up() {
  const std::scoped_lock lock(mutex_);
  return stopping_ && monotonic_now_ns() > deadline_ns_;
}

bool Terminal::wait_until_writable() noexcept {
  while (!time_is_up()) {
    pollfd waited{.fd = descriptor_, .events = POLLOUT, .revents = 0};
    const int count = ::poll(&waited, 1, kLookMs);
    if (count > 0) return (waited.revents & POLLOUT) != 0;
    if (count < 0 && errno != EINTR) return false;
  }
  return false;
}

bool Terminal::write(std::string_view text) noexcept {
  while (!text.empty()) {
    if (!wait_until_writable()) return false;
    const ssize_t size = ::write(descriptor_, text.data(), std::min(text.size(), kAtOnce));
    if (size < 0 && errno != EINTR && errno != EAGAIN) return false;
    if (size > 0) text.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

}  // namespace risorius
