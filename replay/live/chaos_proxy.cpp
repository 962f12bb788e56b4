#include "replay/live/chaos_proxy.h"

#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <utility>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 32;
constexpr std::size_t kSlotBytes = 65536;  // any UDP datagram
constexpr std::size_t kReceiveBuffer = 8 << 20;

udp::endpoint resolve(boost::asio::io_context& io, const SendTarget& target) {
  if (target.transport != Transport::kUdp) {
    throw UserError(to_url(target), "chaos is made with UDP datagrams only", "give udp://HOST:PORT");
  }
  error_code error;
  const auto found = udp::resolver(io).resolve(target.host, std::to_string(target.port), error);
  if (error) throw UserError(to_url(target), error.message(), "is the host's name right?");
  return found.begin()->endpoint();
}

udp::socket bound_socket(boost::asio::io_context& io, const SendTarget& listen) {
  const udp::endpoint endpoint = resolve(io, listen);
  udp::socket socket(io);
  error_code error;
  socket.open(endpoint.protocol(), error);
  if (!error) socket.bind(endpoint, error);
  if (error) {
    throw UserError(to_url(listen), "cannot listen: " + error.message(),
                    "choose an address of this machine and a port that no other program has");
  }
  prepare_receive_buffer(socket.native_handle(), kReceiveBuffer);
  return socket;
}

}  // namespace

ChaosProxy::ChaosProxy(boost::asio::io_context& io, const SendTarget& listen, const SendTarget& to,
                       const ChaosOptions& options)
    : in_(bound_socket(io, listen)),
      out_(io),
      to_(resolve(io, to)),
      timer_(io),
      batch_(kBatch, kSlotBytes),
      plan_(options) {
  out_.open(to_.protocol());
}

std::string ChaosProxy::endpoint() const {
  const auto local = in_.local_endpoint();
  return to_url({.transport = Transport::kUdp, .host = local.address().to_string(), .port = local.port()});
}

void ChaosProxy::wait() {
  in_.async_wait(udp::socket::wait_read, [this](const error_code& error) {
    if (error) return;
    drain();
    wait();
  });
}

void ChaosProxy::drain() {
  const int received = batch_.receive(in_.native_handle(), kBatch);
  const std::int64_t now_ns = monotonic_now_ns();
  for (std::size_t i = 0; std::cmp_less(i, received); ++i) {
    const std::uint32_t drops = batch_.drops(i, known_drops_);
    counts_.kernel_drops += drops - known_drops_;  // modulo 2^32, as the kernel counts
    known_drops_ = drops;
    take(batch_.datagram(i), now_ns);
  }
  send_due(now_ns);
  arm_timer();
}

void ChaosProxy::take(std::span<const std::byte> datagram, std::int64_t now_ns) {
  const std::uint64_t number = counts_.received++;
  if (!native_.offered(datagram)) ++counts_.not_native;
  const ChaosDecision decision = plan_.decide(datagram.size(), now_ns);
  counts_.bursts = plan_.bursts();
  counts_.lost += decision.fate == ChaosFate::kLost ? 1 : 0;
  counts_.lost_in_bursts += decision.fate == ChaosFate::kLostInBurst ? 1 : 0;
  counts_.duplicated += decision.copies == 2 ? 1 : 0;
  for (std::size_t i = 0; i < decision.copies; ++i) {
    const ChaosCopy& planned = decision.copy[i];
    Copy copy{number, {datagram.begin(), datagram.end()}, planned.turned_bit, planned.delay_ns};
    if (planned.held_back > 0) {
      held_.push_back({std::move(copy), number + planned.held_back, now_ns + kLongestHoldNs});
    } else {
      schedule(std::move(copy), now_ns);
    }
  }
  release_held(number, now_ns);
}

void ChaosProxy::release_held(std::uint64_t datagram, std::int64_t now_ns) {
  for (auto held = held_.begin(); held != held_.end();) {
    if (held->until_datagram > datagram && held->until_ns > now_ns) {
      ++held;
      continue;
    }
    schedule(std::move(held->copy), now_ns);
    held = held_.erase(held);
  }
}

void ChaosProxy::schedule(Copy copy, std::int64_t now_ns) {
  if (copy.delay_ns == 0) return send(copy);
  const std::int64_t due_ns = now_ns + copy.delay_ns;
  delayed_.emplace(due_ns, std::move(copy));
}

void ChaosProxy::send_due(std::int64_t now_ns) {
  while (!delayed_.empty() && delayed_.begin()->first <= now_ns) {
    send(delayed_.begin()->second);
    delayed_.erase(delayed_.begin());
  }
}

void ChaosProxy::send(Copy& copy) {
  if (copy.turned_bit) copy.bytes[*copy.turned_bit / 8] ^= std::byte{1} << (*copy.turned_bit % 8);
  error_code error;
  for (int tries = 0; tries < 3; ++tries) {
    out_.send_to(boost::asio::buffer(copy.bytes), to_, 0, error);
    if (error != boost::asio::error::no_buffer_space && error != boost::asio::error::would_block) break;
    pollfd writable{.fd = out_.native_handle(), .events = POLLOUT, .revents = 0};
    ::poll(&writable, 1, 1);
  }
  if (error) {
    ++counts_.not_sent;
    return;
  }
  if (counts_.forwarded++ > 0 && copy.datagram < newest_sent_) ++counts_.overtaken;
  newest_sent_ = std::max(newest_sent_, copy.datagram);
  if (!copy.turned_bit) return native_.forwarded(copy.bytes);
  ++counts_.corrupted;
  // Where the header of a native datagram has its magic and its version (capture/README.md).
  const std::size_t byte = *copy.turned_bit / 8;
  ++(byte < 4 ? counts_.corrupted_magic : byte < 6 ? counts_.corrupted_version : counts_.corrupted_elsewhere);
}

void ChaosProxy::arm_timer() {
  std::int64_t next_ns = std::numeric_limits<std::int64_t>::max();
  if (!delayed_.empty()) next_ns = delayed_.begin()->first;
  for (const Held& held : held_) next_ns = std::min(next_ns, held.until_ns);
  if (next_ns == std::numeric_limits<std::int64_t>::max()) return;
  timer_.expires_after(std::chrono::nanoseconds(std::max<std::int64_t>(0, next_ns - monotonic_now_ns())));
  timer_.async_wait([this](const error_code& error) {
    if (error) return;
    const std::int64_t now_ns = monotonic_now_ns();
    release_held(0, now_ns);
    send_due(now_ns);
    arm_timer();
  });
}

void ChaosProxy::stop() {
  // What came last is still in the socket.
  drain();
  release_held(std::numeric_limits<std::uint64_t>::max(), monotonic_now_ns());
  send_due(std::numeric_limits<std::int64_t>::max());
  timer_.cancel();
  error_code ignored;
  in_.close(ignored);
}

nlohmann::json ChaosProxy::truth() const {
  return {{"datagrams",
           {{"received", counts_.received},
            {"lost", counts_.lost},
            {"lost_in_bursts", counts_.lost_in_bursts},
            {"bursts", counts_.bursts},
            {"forwarded", counts_.forwarded},
            {"duplicated", counts_.duplicated},
            {"overtaken", counts_.overtaken},
            {"corrupted", counts_.corrupted},
            {"corrupted_in",
             {{"magic", counts_.corrupted_magic},
              {"version", counts_.corrupted_version},
              {"elsewhere", counts_.corrupted_elsewhere}}},
            {"not_native", counts_.not_native},
            {"not_sent", counts_.not_sent},
            {"kernel_drops", counts_.kernel_drops}}},
          {"sessions", native_.json()}};
}

}  // namespace risorius
