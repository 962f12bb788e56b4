#include "capture/wire/curve_gate.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

namespace risorius {
namespace {

constexpr const char* kZapAddress = "inproc://zeromq.zap.01";
constexpr std::size_t kPublicKeyBytes = 32;

/// Of a ZAP request: version, request id, domain, address, routing id, mechanism, and for CURVE the public key.
enum ZapPart : std::uint8_t { kVersion, kRequestId, kDomain, kAddress, kRoutingId, kMechanism, kCredential, kParts };

}  // namespace

CurveGate::CurveGate(boost::asio::io_context& io, zmq::context_t& context, CurveServer server, Counter& refused)
    : io_(io), context_(context), server_(std::move(server)), refused_(refused) {
  if (server_.clients.empty()) return;  // without somebody to ask, ZeroMQ lets all in who know the server's key
  questions_ = zmq::socket_t(context, zmq::socket_type::rep);
  questions_.set(zmq::sockopt::linger, 0);
  questions_.bind(kZapAddress);
  asked_.emplace(io, questions_, [this] { return answer_one(); });
}

void CurveGate::guard(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_publickey, server_.keys.public_key);
  socket.set(zmq::sockopt::curve_secretkey, server_.keys.secret_key);
  Guarded& guarded = guarded_.emplace_back(context_, socket);
  guarded.readiness.emplace(io_, guarded.monitor.events(), [this, &guarded] {
    refused_.add(guarded.monitor.take().failed);
    return false;
  });
}

bool CurveGate::answer_one() {
  std::array<zmq::message_t, kParts> request;
  if (!questions_.recv(request[0], zmq::recv_flags::dontwait)) return false;
  std::size_t parts = 1;
  zmq::message_t beyond;
  while (questions_.get(zmq::sockopt::rcvmore)) {
    (void)questions_.recv(parts < kParts ? request[parts] : beyond, zmq::recv_flags::none);  // parts come together
    ++parts;
  }
  bool known = false;
  if (parts == kParts && request[kMechanism].to_string_view() == "CURVE" &&
      request[kCredential].size() == kPublicKeyBytes) {
    std::array<char, kPublicKeyBytes / 4 * 5 + 1> key{};
    zmq_z85_encode(key.data(), request[kCredential].data<std::uint8_t>(), kPublicKeyBytes);
    known = std::binary_search(server_.clients.begin(), server_.clients.end(), std::string(key.data()));
  }
  const std::array<std::string_view, 6> answer{
      "1.0", request[kRequestId].to_string_view(), known ? "200" : "400", known ? "OK" : "unknown key", "", ""};
  for (std::size_t i = 0; i < answer.size(); ++i) {
    questions_.send(zmq::buffer(answer[i]), i + 1 < answer.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
  return true;
}

}  // namespace risorius
