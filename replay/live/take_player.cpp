#include "replay/live/take_player.h"

#include <chrono>
#include <utility>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

using boost::system::error_code;

constexpr auto kClientPoll = std::chrono::milliseconds(2);

// libstdc++'s steady_clock is CLOCK_MONOTONIC.
std::chrono::steady_clock::time_point at(std::int64_t monotonic_ns) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(monotonic_ns));
}

}  // namespace

TakePlayer::TakePlayer(boost::asio::io_context& io, TakeReader& take, TrackerServer& server,
                       const TakePlayerOptions& options, std::function<void()> on_end)
    : take_(take), server_(server), options_(options), on_end_(std::move(on_end)), pacer_(options.pace), timer_(io) {
  if (!read_next()) throw UserError(take.info().path.string(), "has no frames", "give a take with frames");
}

void TakePlayer::start() {
  server_.start(take_.info().markers);
  if (options_.wait_for_client) {
    wait_for_client();
  } else {
    arm();
  }
}

void TakePlayer::stop() noexcept {
  error_code ignored;
  timer_.cancel(ignored);
}

bool TakePlayer::read_next() {
  if (!take_.next(frame_)) {
    if (!options_.loop || frames_ == 0) return false;
    clock_.begin_round(capture_time_of(1, take_.info().markers.rate_hz));
    take_.rewind();
    if (!take_.next(frame_)) return false;
  }
  clock_.place(frame_);
  return true;
}

void TakePlayer::wait_for_client() {
  if (server_.streaming_clients() > 0) return arm();
  timer_.expires_after(kClientPoll);
  timer_.async_wait([this](const error_code& error) {
    if (!error) wait_for_client();
  });
}

void TakePlayer::arm() {
  due_ns_ = pacer_.deadline_ns(frame_.header.capture_time_ns, monotonic_now_ns());
  if (!monotonic_minus_take_ns_) monotonic_minus_take_ns_ = due_ns_ - frame_.header.capture_time_ns;
  timer_.expires_at(at(due_ns_));
  timer_.async_wait([this](const error_code& error) {
    if (!error) play();
  });
}

void TakePlayer::play() {
  server_.send_frame(frame_, frame_.header.capture_time_ns + *monotonic_minus_take_ns_);
  pacer_.record(due_ns_, monotonic_now_ns());
  ++frames_;
  if (read_next()) return arm();
  on_end_();
}

}  // namespace risorius
