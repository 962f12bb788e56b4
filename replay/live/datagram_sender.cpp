#include "replay/live/datagram_sender.h"

#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <limits>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>
#include <zmq.hpp>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"
#include "replay/live/curve_refusal.h"

namespace risorius {

/// Sends one datagram or message.
class DatagramSender::Channel {
 public:
  virtual ~Channel() = default;
  /// False if it could not be sent; every refusal of the system counts into `errors`.
  virtual bool send(std::span<const std::byte> bytes, std::uint64_t& errors) = 0;
  /// How many times a message is sent that must not get lost.
  virtual int copies() const noexcept = 0;
};

class DatagramSender::UdpChannel : public DatagramSender::Channel {
 public:
  explicit UdpChannel(const SendTarget& target) {
    const addrinfo hints{.ai_family = AF_UNSPEC, .ai_socktype = SOCK_DGRAM};
    addrinfo* found = nullptr;
    const int error = getaddrinfo(target.host.c_str(), std::to_string(target.port).c_str(), &hints, &found);
    if (error != 0) throw UserError(to_url(target), gai_strerror(error), "is the host's name right?");
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
    socket_ = ::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ >= 0 && ::connect(socket_, found->ai_addr, found->ai_addrlen) == 0) return;
    const std::string problem = std::generic_category().message(errno);
    if (socket_ >= 0) ::close(socket_);
    throw UserError(to_url(target), "cannot send there: " + problem, "is there a network route to the host?");
  }
  ~UdpChannel() override { ::close(socket_); }
  UdpChannel(const UdpChannel&) = delete;
  UdpChannel& operator=(const UdpChannel&) = delete;

  bool send(std::span<const std::byte> bytes, std::uint64_t& errors) override {
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
      if (::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) >= 0) return true;
      ++errors;
      // ECONNREFUSED reports an earlier datagram, which found nobody listening: this one was not tried at all.
      if (errno == ECONNREFUSED || errno == EINTR) continue;
      if (errno != ENOBUFS && errno != EAGAIN) return false;
      pollfd writable{.fd = socket_, .events = POLLOUT, .revents = 0};
      ::poll(&writable, 1, 1);
    }
    return false;
  }
  int copies() const noexcept override { return 3; }

 private:
  int socket_ = -1;
};

class DatagramSender::ZmqChannel : public DatagramSender::Channel {
 public:
  ZmqChannel(const SendTarget& target, const DatagramSenderOptions& options)
      : place_(to_url(target)), curve_(options.curve.has_value()), socket_(context_, zmq::socket_type::push) {
    give_up_after_ns_ = options.give_up_after_ns;
    const auto give_up_ms = static_cast<int>(options.give_up_after_ns / 1'000'000);
    socket_.set(zmq::sockopt::immediate, true);  // without a receiver, say so instead of queueing for nobody
    socket_.set(zmq::sockopt::sndhwm, options.zmq_high_water_mark);
    socket_.set(zmq::sockopt::sndtimeo, std::min(give_up_ms, kLookMs));
    socket_.set(zmq::sockopt::linger, give_up_ms);
    socket_.set(zmq::sockopt::ipv6, true);
    if (options.curve) use_curve(socket_, *options.curve);
    handshakes_.emplace(context_, socket_);
    try {
      socket_.connect(place_.substr(std::string_view("zmq+").size()));
    } catch (const zmq::error_t& error) {
      throw UserError(place_, std::string("cannot connect: ") + error.what(), "is the host's name right?");
    }
  }

  bool send(std::span<const std::byte> bytes, std::uint64_t& errors) override {
    const std::int64_t give_up_ns = monotonic_now_ns() + give_up_after_ns_;
    while (zmq_send(socket_.handle(), bytes.data(), bytes.size(), 0) < 0) {
      const int problem = errno;
      if (problem == EAGAIN) {
        // A receiver that refuses us will refuse us again: no need to wait for it.
        if (const auto refusal = curve_refusal(*handshakes_, curve_); !refusal.empty()) {
          throw UserError(place_, refusal, kCurveRemedy);
        }
        if (monotonic_now_ns() < give_up_ns) continue;
      }
      ++errors;
      if (problem == EAGAIN) {
        throw UserError(place_, "the receiver takes no messages", "start the receiver, or check host and port");
      }
      if (problem != EINTR) return false;
    }
    return true;
  }
  int copies() const noexcept override { return 1; }

 private:
  static constexpr int kLookMs = 300;  // how often a blocked sender looks why

  std::string place_;
  std::int64_t give_up_after_ns_ = 0;
  bool curve_;
  zmq::context_t context_{1};
  std::optional<HandshakeMonitor> handshakes_;  ///< outlives the socket
  zmq::socket_t socket_;
};

namespace {

const DatagramSenderOptions& checked(const DatagramSenderOptions& options) {
  constexpr std::int64_t kLongest = std::int64_t{std::numeric_limits<int>::max()} * 1'000'000;
  if (options.zmq_high_water_mark < 1) {
    throw UserError("zmq_high_water_mark", fmt::format("{} is out of range", options.zmq_high_water_mark), "1 or more");
  }
  if (options.give_up_after_ns < 1'000'000 || options.give_up_after_ns > kLongest) {
    throw UserError("give_up_after_ns", fmt::format("{} is out of range", options.give_up_after_ns),
                    fmt::format("1000000 to {}", kLongest));
  }
  return options;
}

}  // namespace

DatagramSender::DatagramSender(const SendTarget& target, const DatagramSenderOptions& options) {
  checked(options);
  if (target.transport == Transport::kUdp) {
    if (options.curve) {
      throw UserError(to_url(target), "UDP cannot be encrypted", "send to zmq+tcp://HOST:PORT, or without keys");
    }
    channel_ = std::make_unique<UdpChannel>(target);
  } else {
    channel_ = std::make_unique<ZmqChannel>(target, options);
  }
}

DatagramSender::~DatagramSender() = default;

bool DatagramSender::send(std::span<const std::byte> bytes, std::uint64_t& errors) {
  return channel_->send(bytes, errors);
}

int DatagramSender::copies() const noexcept { return channel_->copies(); }

}  // namespace risorius
