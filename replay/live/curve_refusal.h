// Why a daemon does not talk to us, for those who connect to it over ZeroMQ.
#pragma once

#include <string>

#include "capture/wire/handshake_monitor.h"

namespace risorius {

inline constexpr const char* kCurveRemedy =
    "give --curve-server the daemon's .key file and --curve-key your .key_secret file, whose .key file the daemon's "
    "curve_clients must have";

/// Empty if a connection came about, or nobody is there at all. `curve`: whether we connect with a key.
inline std::string curve_refusal(HandshakeMonitor& monitor, bool curve) {
  const Handshakes handshakes = monitor.take();
  if (handshakes.succeeded > 0 || handshakes.failed == 0) return {};
  return curve ? "refuses our key, or has another key than --curve-server, or none"
               : "does not talk to those who have no key";
}

}  // namespace risorius
