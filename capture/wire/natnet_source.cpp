#include "capture/wire/natnet_source.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <fmt/format.h>
#include <netinet/in.h>
#include <optional>
#include <utility>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "capture/wire/flood_rest.h"
#include "capture/wire/receive_batch.h"

namespace risorius {
namespace {

using boost::asio::ip::address_v4;
using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 16;
constexpr std::size_t kMaxBatchesPerWakeUp = 8;
constexpr std::int64_t kLeastTimerNs = 1'000'000;
constexpr std::int64_t kOpenAgainNs = 500'000'000;

address_v4 parse_address(const std::string& text, const std::string& key) {
  error_code error;
  const auto address = boost::asio::ip::make_address_v4(text, error);
  if (error) throw UserError(key, "\"" + text + "\" is no IPv4 address", "such as 192.168.1.10");
  return address;
}

udp::endpoint resolved(boost::asio::io_context& io, const NatnetSourceOptions& options) {
  error_code error;
  udp::resolver resolver(io);
  const auto found = resolver.resolve(udp::v4(), options.host, std::to_string(options.command_port), error);
  if (error || found.empty()) {
    throw UserError("natnet://" + options.host, "cannot find the host: " + error.message(),
                    "give the IPv4 address of the machine that Motive runs on");
  }
  return found.begin()->endpoint();
}

/// Of the interface from which the system reaches the server.
address_v4 own_address(boost::asio::io_context& io, const udp::endpoint& server) {
  udp::socket probe(io, udp::v4());
  error_code error;
  probe.connect(server, error);  // sends nothing
  if (error) {
    throw UserError("natnet://" + server.address().to_string(), "cannot be reached: " + error.message(),
                    "is there a network route to it?");
  }
  return probe.local_endpoint().address().to_v4();
}

void open(udp::socket& socket, const udp::endpoint& endpoint, bool shared, error_code& error) {
  socket.open(udp::v4(), error);
  if (!error && shared) socket.set_option(udp::socket::reuse_address(true), error);
  if (!error) socket.bind(endpoint, error);
}

const NatnetSourceOptions& checked(const NatnetSourceOptions& options) {
  if (options.receive_buffer_bytes < 1024 || options.receive_buffer_bytes > (std::size_t{1} << 30)) {
    throw UserError("receive_buffer_bytes", fmt::format("{} is out of range", options.receive_buffer_bytes),
                    "1024 to 1073741824 bytes");
  }
  return options;
}

struct Port {
  explicit Port(boost::asio::io_context& io) : socket(io), rest_timer(io) {}
  udp::socket socket;
  boost::asio::steady_timer rest_timer;
  FloodRest rest;
  std::uint32_t known_drops = 0;
  bool waiting = false;
};

}  // namespace

struct NatnetSource::Impl : std::enable_shared_from_this<NatnetSource::Impl> {
  Impl(boost::asio::io_context& io, const NatnetSourceOptions& chosen, std::function<void()> ready)
      : options(checked(chosen)),
        session(options.session),
        counters(session.counters()),
        server(resolved(io, options)),
        local(options.local_address.empty() ? own_address(io, server)
                                            : parse_address(options.local_address, "local_address")),
        command(io),
        data(io),
        timer(io),
        on_ready(std::move(ready)) {
    error_code error;
    open(command.socket, udp::endpoint(local, 0), false, error);
    if (error) {
      throw UserError("local_address", "cannot listen on " + local.to_string() + ": " + error.message(),
                      "give the address of an interface of this machine");
    }
    counters.granted_buffer_bytes.set(
        prepare_receive_buffer(command.socket.native_handle(), options.receive_buffer_bytes));
    if (!options.multicast_group.empty()) group = parse_address(options.multicast_group, "multicast_group");
    if (group && !group->is_multicast()) {
      throw UserError("multicast_group", "\"" + options.multicast_group + "\" is no multicast address",
                      "such as 239.255.42.99, or \"\" for what the server says");
    }
    open_data_port(error);
    if (error && (group || options.data_port != 0)) {
      throw UserError("data_port", fmt::format("cannot listen on {}: {}", data_port, error.message()),
                      "another program has this port: stop it, or give 0 where the server sends unicast");
    }
  }

  /// At the group or at our own address. A unicast server that sends to the command port can do without.
  void open_data_port(error_code& error) {
    data.socket.close(error);
    data.rest_timer.cancel();
    data.waiting = false;
    data.known_drops = 0;
    open(data.socket, udp::endpoint(group.value_or(local), data_port), group.has_value(), error);
    if (!error && group) data.socket.set_option(boost::asio::ip::multicast::join_group(*group, local), error);
    if (!error) {
      prepare_receive_buffer(data.socket.native_handle(), options.receive_buffer_bytes);
      return;
    }
    error_code ignored;
    data.socket.close(ignored);
  }

  /// What the server has said of its data port.
  void follow_server() {
    if (!session.server()) return;
    const NatnetServerInfo& info = *session.server();
    const std::uint16_t port = options.data_port != 0 || info.data_port == 0 ? data_port : info.data_port;
    const address_v4 said(info.group);
    const auto wanted = options.multicast_group.empty() && info.multicast && said.is_multicast()
                            ? std::optional<address_v4>(said)
                            : group;
    // A port that was busy is tried again now and then, until it opens.
    const bool same = port == data_port && wanted == group;
    if (same && (data.socket.is_open() || monotonic_now_ns() < open_again_ns)) return;
    open_again_ns = monotonic_now_ns() + kOpenAgainNs;
    data_port = port;
    group = wanted;
    error_code error;
    open_data_port(error);
    if (error) counters.receive_errors.add();
    wait(data);
  }

  void wait(Port& port) {
    if (port.waiting || !port.socket.is_open()) return;
    port.waiting = true;
    port.socket.async_wait(udp::socket::wait_read, [self = shared_from_this(), &port](const error_code& error) {
      if (error) return;
      port.waiting = false;
      if (self->running) self->drain(port);
    });
  }

  bool is_from_server(std::size_t i) const noexcept {
    const auto& sender = reinterpret_cast<const sockaddr_in&>(batch.sender(i));
    return sender.sin_family == AF_INET && ntohl(sender.sin_addr.s_addr) == server.address().to_v4().to_uint();
  }

  // True if the socket may have more.
  bool receive_batch(Port& port) noexcept {
    const std::size_t limit = std::min(kBatch, session.datagrams_until_full());
    if (limit == 0) return false;
    const int received = batch.receive(port.socket.native_handle(), limit);
    const std::int64_t receive_time_ns = monotonic_now_ns();
    if (received < 0) {
      if (errno != EAGAIN && errno != EINTR) counters.receive_errors.add();
      return false;
    }
    const auto count = static_cast<std::size_t>(received);
    for (std::size_t i = 0; i < count; ++i) {
      if (batch.truncated(i)) counters.truncated.add();
      const std::uint32_t drops = batch.drops(i, port.known_drops);
      counters.kernel_drops.add(drops - port.known_drops);  // modulo 2^32, as the kernel counts
      port.known_drops = drops;
      const std::uint64_t refused = counters.datagrams.refused.value();
      const bool is_known = is_from_server(i);
      if (is_known) {
        session.push(batch.datagram(i), receive_time_ns);
      } else {
        session.push_foreign();
      }
      const bool is_refused = !is_known || counters.datagrams.refused.value() > refused;
      tap(batch.datagram(i), batch.sender(i), receive_time_ns, is_refused);
    }
    return count == limit;
  }

  std::uint64_t useless() const noexcept {
    return counters.datagrams.refused.value() + counters.datagrams.dropped.value();
  }

  void rest(Port& port, std::chrono::microseconds time) {
    counters.rests.add();
    port.waiting = true;
    port.rest_timer.expires_after(time);
    port.rest_timer.async_wait([self = shared_from_this(), &port](const error_code& error) {
      if (error) return;
      port.waiting = false;
      if (self->running) self->drain(port);
    });
  }

  void drain(Port& port) {
    counters.wake_ups.add();
    const std::uint64_t received_before = counters.datagrams.received.value(), useless_before = useless();
    bool more = true;
    for (std::size_t i = 0; i < kMaxBatchesPerWakeUp && more; ++i) more = receive_batch(port);
    const bool was_useless =
        more && useless() - useless_before >= counters.datagrams.received.value() - received_before;
    if (const auto time = port.rest.after_turn(was_useless); time.count() > 0) rest(port, time);
    on_ready();
    if (!running) return;
    send_outgoing();
    follow_server();
    arm_timer();
    if (session.ready()) {
      wait_for_both();
    } else if (!std::exchange(paused, true)) {
      counters.pauses.add();
    }
  }

  void wait_for_both() {
    paused = false;
    wait(command);
    wait(data);
  }

  void send_outgoing() {
    while (session.pop_datagram(outgoing)) {
      error_code error;
      command.socket.send_to(boost::asio::buffer(outgoing), server, 0, error);
      // A server that is not there is what the next try is for.
    }
  }

  void arm_timer() {
    const std::int64_t due_ns = std::max(session.next_tick_ns(), monotonic_now_ns() + kLeastTimerNs);
    if (timer_armed && timer_ns <= due_ns) return;
    timer_armed = true;
    timer_ns = due_ns;
    timer.expires_at(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(due_ns)));
    timer.async_wait([self = shared_from_this()](const error_code& error) {
      if (!error && self->running) self->tick();
    });
  }

  void tick() {
    timer_armed = false;
    session.tick(Tick{.stream_id = options.session.stream_id, .time_ns = monotonic_now_ns()});
    on_ready();
    if (!running) return;
    send_outgoing();
    arm_timer();
  }

  NatnetSourceOptions options;
  NatnetSession session;
  SourceCounters& counters;
  udp::endpoint server;
  address_v4 local;
  std::optional<address_v4> group;  ///< joined, or to be joined
  std::uint16_t data_port = options.data_port != 0 ? options.data_port : kNatnetDataPort;
  Port command, data;
  boost::asio::steady_timer timer;
  std::int64_t timer_ns = 0, open_again_ns = 0;
  std::function<void()> on_ready;
  ReceiveBatch batch{kBatch, kMaxNatnetDatagramBytes + 1};
  NatnetDatagram outgoing;
  RawTap tap;
  bool running = false, paused = false, timer_armed = false;
};

NatnetSource::NatnetSource(boost::asio::io_context& io, const NatnetSourceOptions& options,
                           std::function<void()> on_ready)
    : impl_(std::make_shared<Impl>(io, options, std::move(on_ready))) {}

NatnetSource::~NatnetSource() { stop(); }

void NatnetSource::tap_raw(const RawTap& tap) noexcept { impl_->tap = tap; }

void NatnetSource::start() {
  if (impl_->running || !impl_->command.socket.is_open()) return;
  impl_->running = true;
  impl_->wait_for_both();
  impl_->tick();
}

void NatnetSource::stop() noexcept {
  if (std::exchange(impl_->running, false) && impl_->session.server()) {
    encode_bare(NatnetMessage::kDisconnect, impl_->outgoing);
    error_code ignored;
    impl_->command.socket.send_to(boost::asio::buffer(impl_->outgoing), impl_->server, 0, ignored);
  }
  error_code ignored;
  impl_->timer.cancel(ignored);
  for (Port* port : {&impl_->command, &impl_->data}) port->rest_timer.cancel();
  impl_->command.socket.close(ignored);
  impl_->data.socket.close(ignored);
}

void NatnetSource::resume() {
  if (impl_->running && impl_->paused && impl_->session.ready()) impl_->wait_for_both();
}

bool NatnetSource::pop(SourceEvent& event) noexcept { return impl_->session.pop(event); }
void NatnetSource::flush() noexcept { impl_->session.flush(); }
const SourceCounters& NatnetSource::counters() const noexcept { return impl_->counters; }
bool NatnetSource::pop_clock_sample(ClockSample& sample) noexcept { return impl_->session.pop_clock_sample(sample); }
std::string NatnetSource::endpoint() const {
  return fmt::format("natnet://{}:{}", impl_->options.host, impl_->options.command_port);
}

}  // namespace risorius
