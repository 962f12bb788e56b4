#include "replay/live/tcp_server.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <poll.h>
#include <utility>
#include <vector>

#include "capture/errors.h"
#include "capture/monotonic_clock.h"

namespace risorius {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::int64_t kLongestFarewellNs = 500'000'000;
constexpr std::size_t kAnswerShare = 2;  // answers may fill the queue to twice what frames may

bool is_only_busy(const error_code& error) {
  return error == boost::asio::error::would_block || error == boost::asio::error::try_again ||
         error == boost::asio::error::interrupted;
}

tcp::acceptor bound_acceptor(boost::asio::io_context& io, const std::string& scheme, const TcpServerOptions& options) {
  const std::string place = fmt::format("{}://{}:{}", scheme, options.address, options.port);
  error_code error;
  const auto address = boost::asio::ip::make_address(options.address, error);
  if (error) throw UserError(place, "the address is no IP address", "use 127.0.0.1, or 0.0.0.0 for all interfaces");
  tcp::acceptor acceptor(io);
  acceptor.open(tcp::endpoint(address, options.port).protocol(), error);
  // A server that starts over must not wait for connections of before to be forgotten.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(tcp::endpoint(address, options.port), error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (!error) return acceptor;
  const bool busy = error == boost::asio::error::address_in_use;
  throw UserError(place, "cannot listen: " + error.message(),
                  busy ? "another program has this port: stop it or choose another port"
                       : "choose an address of this machine and a port above 1023");
}

struct Client {
  explicit Client(tcp::socket accepted, std::size_t buffer_bytes) : socket(std::move(accepted)), buffer(buffer_bytes) {}
  tcp::socket socket;
  std::vector<std::byte> buffer;  ///< the first `filled` bytes are in use
  std::size_t filled = 0;
  std::vector<std::byte> queue;
  bool writing = false;
};

}  // namespace

struct TcpServer::Impl : std::enable_shared_from_this<TcpServer::Impl> {
  Impl(boost::asio::io_context& io, const std::string& scheme, const TcpServerOptions& chosen, Handlers given)
      : options(chosen), handlers(std::move(given)), acceptor(bound_acceptor(io, scheme, chosen)) {
    port = acceptor.local_endpoint().port();
  }

  void accept() {
    acceptor.async_accept([self = shared_from_this()](const error_code& error, tcp::socket socket) {
      if (!self->running) return;
      if (!error) self->join(std::move(socket));
      self->accept();
    });
  }

  void join(tcp::socket socket) {
    if (clients.size() >= options.most_clients) return;
    error_code ignored;
    socket.non_blocking(true, ignored);
    socket.set_option(tcp::no_delay(true), ignored);
    const ClientId id = ++last_id;
    clients.emplace(id, std::make_unique<Client>(std::move(socket), options.read_buffer_bytes));
    handlers.joined(id);
    wait_to_read(id);
  }

  Client* find(ClientId id) {
    const auto found = clients.find(id);
    return found == clients.end() ? nullptr : found->second.get();
  }

  void leave(ClientId id) {
    if (clients.erase(id) > 0 && running) handlers.left(id);
  }

  void wait_to_read(ClientId id) {
    Client* client = find(id);
    if (client == nullptr) return;
    client->socket.async_wait(tcp::socket::wait_read, [self = shared_from_this(), id](const error_code& error) {
      if (!self->running) return;
      if (error || !self->read(id)) return self->leave(id);
      self->wait_to_read(id);
    });
  }

  /// False if the client is to go.
  bool read(ClientId id) {
    Client* client = find(id);
    if (client == nullptr) return false;
    const auto room =
        boost::asio::buffer(client->buffer.data() + client->filled, client->buffer.size() - client->filled);
    error_code error;
    client->filled += client->socket.read_some(room, error);
    if (error) return is_only_busy(error);
    const auto used = handlers.received(id, std::span<const std::byte>(client->buffer).first(client->filled));
    client = find(id);
    if (!used || client == nullptr) return false;
    std::memmove(client->buffer.data(), client->buffer.data() + *used, client->filled - *used);
    client->filled -= *used;
    return client->filled < client->buffer.size();
  }

  void write(ClientId id) {
    Client* client = find(id);
    if (client == nullptr) return;
    error_code error;
    const std::size_t size = client->socket.write_some(boost::asio::buffer(client->queue), error);
    if (error && !is_only_busy(error)) return shut(*client);
    if (!error) client->queue.erase(client->queue.begin(), client->queue.begin() + static_cast<std::ptrdiff_t>(size));
    client->writing = !client->queue.empty();
    if (!client->writing) return;
    client->socket.async_wait(tcp::socket::wait_write, [self = shared_from_this(), id](const error_code& failed) {
      if (!failed && self->running) self->write(id);
    });
  }

  /// The waiting read then finds the end and removes the client: nobody is removed inside of a call about him.
  static void shut(Client& client) {
    error_code ignored;
    client.queue.clear();
    client.socket.shutdown(tcp::socket::shutdown_both, ignored);
  }

  bool enqueue(ClientId id, std::span<const std::byte> bytes, std::size_t limit) {
    Client* client = find(id);
    if (client == nullptr || client->queue.size() + bytes.size() > limit) return false;
    client->queue.insert(client->queue.end(), bytes.begin(), bytes.end());
    if (!client->writing) write(id);
    return true;
  }

  /// A socket that is closed with unread bytes resets the connection, and the client loses what it has not read.
  static void say_farewell(Client& client, std::int64_t until_ns) noexcept {
    error_code error;
    const auto wait = [&](short events) {
      const auto left_ms = static_cast<int>((until_ns - monotonic_now_ns()) / 1'000'000);
      pollfd ready{.fd = client.socket.native_handle(), .events = events, .revents = 0};
      return left_ms > 0 && ::poll(&ready, 1, left_ms) > 0;
    };
    while (!client.queue.empty() && wait(POLLOUT)) {
      const std::size_t size = client.socket.write_some(boost::asio::buffer(client.queue), error);
      if (error && !is_only_busy(error)) return;
      client.queue.erase(client.queue.begin(), client.queue.begin() + static_cast<std::ptrdiff_t>(size));
    }
    client.socket.shutdown(tcp::socket::shutdown_send, error);
    std::array<std::byte, 4096> unread;
    do {
      client.socket.read_some(boost::asio::buffer(unread), error);
    } while (!error || (is_only_busy(error) && wait(POLLIN)));
  }

  TcpServerOptions options;
  Handlers handlers;
  tcp::acceptor acceptor;
  std::map<ClientId, std::unique_ptr<Client>> clients;
  ClientId last_id = 0;
  std::uint16_t port = 0;
  bool running = false;
};

TcpServer::TcpServer(boost::asio::io_context& io, const std::string& scheme, const TcpServerOptions& options,
                     Handlers handlers)
    : impl_(std::make_shared<Impl>(io, scheme, options, std::move(handlers))) {}

TcpServer::~TcpServer() { finish(); }

void TcpServer::start() {
  impl_->running = true;
  impl_->accept();
}

void TcpServer::finish() noexcept {
  impl_->running = false;
  error_code ignored;
  impl_->acceptor.close(ignored);
  const std::int64_t until_ns = monotonic_now_ns() + kLongestFarewellNs;
  for (auto& [id, client] : impl_->clients) Impl::say_farewell(*client, until_ns);
  impl_->clients.clear();
}

void TcpServer::send(ClientId client, std::span<const std::byte> bytes) {
  if (impl_->enqueue(client, bytes, kAnswerShare * impl_->options.queue_bytes)) return;
  if (Client* found = impl_->find(client)) Impl::shut(*found);
}

bool TcpServer::send_frame(ClientId client, std::span<const std::byte> bytes) {
  return impl_->enqueue(client, bytes, impl_->options.queue_bytes);
}

void TcpServer::close(ClientId client) {
  if (Client* found = impl_->find(client)) {
    error_code ignored;
    found->socket.shutdown(tcp::socket::shutdown_both, ignored);
  }
}

std::uint16_t TcpServer::port() const noexcept { return impl_->port; }

std::string TcpServer::peer_address(ClientId client) const {
  Client* found = impl_->find(client);
  if (found == nullptr) return {};
  error_code error;
  const auto endpoint = found->socket.remote_endpoint(error);
  return error ? "" : endpoint.address().to_string();
}

}  // namespace risorius
