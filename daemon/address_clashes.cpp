#include "daemon/address_clashes.h"

#include <fmt/format.h>
#include <string>
#include <vector>

#include "capture/errors.h"
#include "daemon/source_address.h"

namespace risorius {
namespace {

/// What a socket of ours is bound to.
struct Bound {
  std::string key, text;              ///< as the configuration has it
  std::string transport, host, port;  ///< of an address without a port `host` is all of it
};

bool is_any_host(const std::string& host) { return host == "*" || host == "0.0.0.0" || host == "::"; }

bool clash(const Bound& a, const Bound& b) {
  return a.transport == b.transport && a.port == b.port &&
         (a.host == b.host || is_any_host(a.host) || is_any_host(b.host));
}

/// The system chooses another one for each.
bool is_any_port(const std::string& port) { return port == "0" || port == "*"; }

std::string plain_host(std::string host) {
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return host == "localhost" ? "127.0.0.1" : host;
}

/// Of ZeroMQ: tcp://HOST:PORT, or ipc://PATH and the like.
Bound zmq_bound(const std::string& key, const std::string& text) {
  const auto colon = text.rfind(':');
  if (!text.starts_with("tcp://") || colon < 6) return {key, text, "other", text, ""};
  return {key, text, "tcp", plain_host(text.substr(6, colon - 6)), text.substr(colon + 1)};
}

/// No transport: it binds nothing that another could take. Two subjects of one QTM or Vicon server are two connections.
Bound source_bound(const std::string& key, const std::string& text) {
  try {
    const SourceAddress address = parse_source_address(text);
    const auto bound = [&](const char* transport) {
      return Bound{key, text, transport, plain_host(address.host), std::to_string(address.port)};
    };
    switch (address.kind) {
      case SourceKind::kUdp:
      case SourceKind::kLiveLink:
        return bound("udp");
      case SourceKind::kZmq:
        return bound("tcp");
      case SourceKind::kNatnet:
        return bound("natnet");
      case SourceKind::kQtm:
      case SourceKind::kVicon:
        break;
    }
  } catch (const UserError&) {
  }
  return {};
}

}  // namespace

void refuse_address_clashes(const Config& config, ConfigProblems& problems) {
  std::vector<Bound> taken;
  const auto take = [&](const Bound& bound) {
    if (bound.transport.empty() || is_any_port(bound.port)) return;
    for (const Bound& other : taken) {
      if (!clash(bound, other)) continue;
      problems.add(bound.key, fmt::format("{} is taken by {}: {}", shown(bound.text), other.key, shown(other.text)),
                   "give each a port of its own");
      return;
    }
    taken.push_back(bound);
  };
  take(zmq_bound("output.publish", config.output.publish));
  take(zmq_bound("output.control", config.output.control));
  for (std::size_t i = 0; i < config.sources.size(); ++i)
    take(source_bound(fmt::format("source[{}].listen", i), config.sources[i].listen));
}

}  // namespace risorius
