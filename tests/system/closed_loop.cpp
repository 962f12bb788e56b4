#include "system/closed_loop.h"

#include <algorithm>
#include <stdexcept>

#include "capture/monotonic_clock.h"
#include "replay/live/pacer.h"
#include "solve/faces/builtin_face.h"

namespace risorius::test {

ClosedLoop::ClosedLoop(const RunningDaemon& daemon, const std::string& source, double rate_hz, std::size_t markers)
    : rate_hz_(rate_hz),
      take_(builtin_rig(), PerformerOptions{.rate_hz = rate_hz, .seconds = 600}),
      set_(take_.info().markers),
      sender_(parse_send_target(daemon.input(source))),
      answers_(context_, zmq::socket_type::sub) {
  answers_.set(zmq::sockopt::subscribe, "au");
  answers_.set(zmq::sockopt::rcvtimeo, 10'000);  // so long that an answer after that is none on any machine
  answers_.connect(daemon.publish());
  while (set_.names.size() < markers) set_.names.push_back("extra" + std::to_string(set_.names.size()));
  sender_.send_marker_set(set_);
}

std::uint64_t ClosedLoop::run(double seconds, std::vector<double>& latency_ms) {
  std::uint64_t unanswered = 0;
  Pacer pacer;
  for (int i = 0; i < static_cast<int>(seconds * rate_hz_); ++i) {
    const MarkerFrame& frame = next();
    pacer.wait(frame.header.capture_time_ns);
    zmq::message_t message;
    while (answers_.recv(message, zmq::recv_flags::dontwait)) {
    }
    const std::int64_t sent_ns = monotonic_now_ns();
    sender_.send_frame(frame);
    if (answers_.recv(message)) {
      latency_ms.push_back(static_cast<double>(monotonic_now_ns() - sent_ns) * 1e-6);
    } else {
      ++unanswered;
    }
  }
  return unanswered;
}

const MarkerFrame& ClosedLoop::next() {
  if (!take_.next(frame_)) {
    clock_.begin_round(capture_time_of(1, rate_hz_));
    take_.rewind();
    take_.next(frame_);
  }
  clock_.place(frame_);
  frame_.header.set_id = set_.id;
  const std::uint32_t own = frame_.count;
  frame_.count = static_cast<std::uint32_t>(set_.names.size());
  for (std::uint32_t m = own; m < frame_.count; ++m) {
    frame_.state[m] = MarkerState::kMeasured;
    frame_.position_mm[m] = frame_.position_mm[m - own];
    frame_.position_mm[m].z += 7;  // not on the marker that it copies: that would be a ghost
  }
  return frame_;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) throw std::runtime_error("the daemon answers nothing");
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace risorius::test
