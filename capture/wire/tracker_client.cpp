#include "capture/wire/tracker_client.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <netinet/in.h>
#include <optional>
#include <utility>

#include "capture/monotonic_clock.h"
#include "capture/wire/flood_rest.h"
#include "capture/wire/receive_batch.h"

namespace risorius {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t kBatch = 16, kLongestDatagram = 65536;
constexpr std::size_t kMaxBatchesPerWakeUp = 8;
/// More than the socket's buffer holds: whoever sends faster than we read must not keep us from the connection.
constexpr std::size_t kMaxBatchesBeforeTheConnection = 2048;
constexpr auto kTickPeriod = std::chrono::milliseconds(100);
constexpr auto kTickPeriodWhileHeld = std::chrono::milliseconds(5);

bool comes_from(const sockaddr_storage& sender, const boost::asio::ip::address& peer) {
  if (sender.ss_family == AF_INET && peer.is_v4()) {
    return reinterpret_cast<const sockaddr_in&>(sender).sin_addr.s_addr == htonl(peer.to_v4().to_uint());
  }
  if (sender.ss_family != AF_INET6 || !peer.is_v6()) return false;
  const auto bytes = peer.to_v6().to_bytes();
  return std::memcmp(reinterpret_cast<const sockaddr_in6&>(sender).sin6_addr.s6_addr, bytes.data(), 16) == 0;
}

}  // namespace

struct TrackerClient::Impl : std::enable_shared_from_this<TrackerClient::Impl> {
  Impl(boost::asio::io_context& context, const TrackerClientOptions& chosen, std::unique_ptr<TrackerSession> given,
       std::function<void()> ready)
      : io(context),
        options(chosen),
        session(std::move(given)),
        on_ready(std::move(ready)),
        timer(io),
        datagrams(io),
        rest_timer(io),
        link(io, chosen.link,
             {.connected = [this] { connected(); },
              .received = [this](auto bytes, std::int64_t time_ns) { return received(bytes, time_ns); },
              .round_done = [this] { return round_done(); },
              .lost = [this] { lost(); }}) {}

  SourceCounters& counters() noexcept { return session->counters(); }

  void connected() {
    counters().reconnects.set(link.counters().connections.value() - 1);
    if (!options.udp_frames) {
      counters().granted_buffer_bytes.set(link.counters().granted_buffer_bytes.value());
    } else if (!open_datagrams()) {
      return link.drop();
    }
    session->connected(monotonic_now_ns());
    say();
  }

  /// What was not used is offered again: it is not yet told to the tap.
  std::optional<std::size_t> received(std::span<const std::byte> bytes, std::int64_t time_ns) {
    // The tracker sent these datagrams before it said this: an end of the capture must not overtake its frames.
    if (!drain_datagrams()) return std::nullopt;
    const std::size_t used = session->receive(bytes, time_ns);
    // A piece of a connection has more than one packet, and an unusable one ends the connection: no flood comes here.
    if (tap && used > 0) tap({bytes.first(used), RawOrigin{}, time_ns, false});
    return used;
  }

  /// At our end of the connection, on a port of the system's choice: nothing else can reach it from other networks.
  bool open_datagrams() {
    error_code error;
    peer = boost::asio::ip::make_address(link.peer_address(), error);
    const auto own = boost::asio::ip::make_address(link.local_address(), error);
    if (error) return false;
    const udp::endpoint endpoint(own, 0);
    datagrams.open(endpoint.protocol(), error);
    if (!error) datagrams.bind(endpoint, error);
    if (error) return false;
    counters().granted_buffer_bytes.set(
        prepare_receive_buffer(datagrams.native_handle(), options.receive_buffer_bytes));
    if (!batch) batch.emplace(kBatch, kLongestDatagram);
    known_drops = 0;
    session->use_udp_port(datagrams.local_endpoint().port());
    wait_for_datagrams();
    return true;
  }

  void wait_for_datagrams() {
    datagrams.async_wait(udp::socket::wait_read, [self = shared_from_this()](const error_code& error) {
      if (!error && self->running && self->datagrams.is_open()) self->receive_datagrams();
    });
  }

  bool receive_batch() {
    const std::size_t most = std::min(kBatch, session->room_for_packets());
    if (most == 0) return false;
    const int received = batch->receive(datagrams.native_handle(), most);
    const std::int64_t time_ns = monotonic_now_ns();
    if (received < 0) {
      if (errno != EAGAIN && errno != EINTR) counters().receive_errors.add();
      return false;
    }
    const auto count = static_cast<std::size_t>(received);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t drops = batch->drops(i, known_drops);
      counters().kernel_drops.add(drops - known_drops);  // modulo 2^32, as the kernel counts
      known_drops = drops;
      const std::uint64_t refused = counters().datagrams.refused.value();
      const bool is_known = comes_from(batch->sender(i), peer);
      if (is_known) {
        session->receive_datagram(batch->datagram(i), time_ns);
      } else {
        counters().foreign.add();
      }
      const bool is_refused = !is_known || counters().datagrams.refused.value() > refused;
      tap(batch->datagram(i), batch->sender(i), time_ns, is_refused);
    }
    return count == most;
  }

  /// False if there is no room for what still waits.
  bool drain_datagrams() {
    for (std::size_t i = 0; datagrams.is_open() && i < kMaxBatchesBeforeTheConnection; ++i) {
      if (!session->ready()) on_ready();
      if (!running || !session->ready()) return false;
      if (!receive_batch() && session->ready()) break;
    }
    return true;
  }

  std::uint64_t heard() noexcept { return counters().foreign.value() + counters().datagrams.received.value(); }
  std::uint64_t useless() noexcept {
    return counters().foreign.value() + counters().datagrams.refused.value() + counters().datagrams.dropped.value();
  }

  void receive_datagrams() {
    counters().wake_ups.add();
    const std::uint64_t heard_before = heard(), useless_before = useless();
    bool more = true;
    for (std::size_t i = 0; i < kMaxBatchesPerWakeUp && more; ++i) more = receive_batch();
    const bool was_useless = more && useless() - useless_before >= heard() - heard_before;
    const auto rest = flood_rest.after_turn(was_useless);
    const bool go_on = round_done();
    if (running && datagrams.is_open() && go_on) {
      if (rest.count() > 0) {
        wait_for_datagrams_after(rest);
      } else {
        wait_for_datagrams();
      }
    }
    datagrams_paused = !go_on;
  }

  void wait_for_datagrams_after(std::chrono::microseconds rest) {
    counters().rests.add();
    rest_timer.expires_after(rest);
    rest_timer.async_wait([self = shared_from_this()](const error_code& error) {
      if (!error && self->running && self->datagrams.is_open()) self->receive_datagrams();
    });
  }

  /// What follows any bytes: replies go out, events are taken. False if there is no room for more events.
  bool round_done() {
    counters().wake_ups.set(link.counters().wake_ups.value());
    if (counters().link == LinkState::kStreaming) link.healthy();
    say();
    on_ready();
    if (!running) return false;
    if (!session->ready()) counters().pauses.add();
    watch_held_frames();
    return session->ready();
  }

  void say() {
    if (session->outbox().size() > 0) link.send(session->outbox().bytes());
    session->outbox().clear();
    if (session->failed()) link.drop();
  }

  void lost() {
    drain_datagrams();
    error_code ignored;
    datagrams.close(ignored);
    rest_timer.cancel();
    datagrams_paused = false;
    session->disconnected();
    on_ready();
  }

  void watch_held_frames() {
    if (!ticking_fast && counters().datagrams.held.value() > 0) arm_timer();
  }

  void arm_timer() {
    ticking_fast = counters().datagrams.held.value() > 0;
    timer.expires_after(ticking_fast ? kTickPeriodWhileHeld : kTickPeriod);
    timer.async_wait([self = shared_from_this()](const error_code& error) {
      if (!error && self->running) self->tick();
    });
  }

  void tick() {
    if (link.connected()) {
      session->tick(monotonic_now_ns());
      say();
      on_ready();
    }
    if (running) arm_timer();
  }

  boost::asio::io_context& io;
  TrackerClientOptions options;
  std::unique_ptr<TrackerSession> session;
  std::function<void()> on_ready;
  boost::asio::steady_timer timer;
  udp::socket datagrams;
  boost::asio::steady_timer rest_timer;
  FloodRest flood_rest;
  boost::asio::ip::address peer;
  std::optional<ReceiveBatch> batch;
  std::uint32_t known_drops = 0;
  RawTap tap;
  bool running = false, ticking_fast = false, datagrams_paused = false;
  TcpLink link;
};

TrackerClient::TrackerClient(boost::asio::io_context& io, const TrackerClientOptions& options,
                             std::unique_ptr<TrackerSession> session, std::function<void()> on_ready)
    : impl_(std::make_shared<Impl>(io, options, std::move(session), std::move(on_ready))) {}

TrackerClient::~TrackerClient() { stop(); }

void TrackerClient::tap_raw(const RawTap& tap) noexcept { impl_->tap = tap; }

void TrackerClient::start() {
  if (std::exchange(impl_->running, true)) return;
  impl_->link.start();
  impl_->arm_timer();
}

void TrackerClient::stop() noexcept {
  impl_->running = false;
  impl_->link.stop();
  error_code ignored;
  impl_->datagrams.close(ignored);
  impl_->timer.cancel();
  impl_->rest_timer.cancel();
}

void TrackerClient::resume() {
  if (!impl_->running) return;
  impl_->link.resume();
  if (std::exchange(impl_->datagrams_paused, false) && impl_->datagrams.is_open()) impl_->wait_for_datagrams();
}

bool TrackerClient::pop(SourceEvent& event) noexcept { return impl_->session->pop(event); }
void TrackerClient::flush() noexcept { impl_->session->flush(); }
bool TrackerClient::keeps_order() const noexcept { return !impl_->options.udp_frames; }
std::string TrackerClient::endpoint() const { return impl_->options.url; }
const SourceCounters& TrackerClient::counters() const noexcept { return impl_->session->counters(); }
const TrackerSession& TrackerClient::session() const noexcept { return *impl_->session; }

}  // namespace risorius
