// risorius replay FILE.mcap: a recorded stream once more, as it came (replay/session/session_player.h): same order,
// same moments, so loss and jitter are those of the session.
#pragma once

#include <optional>
#include <string>

#include "capture/wire/curve_keys.h"

namespace risorius {

struct SessionReplay {
  std::string path, stream;  ///< stream: may be empty if there is one
  std::string target;        ///< udp:// or zmq+tcp://
  double speed = 1;          ///< 0: as fast as the other side takes it
  bool quiet = false;
  std::optional<CurveClient> curve;
};

/// By its name: "NAME.mcap".
bool is_session_file(const std::string& path);

/// Until its end or SIGINT. Throws UserError.
void replay_session(const SessionReplay& replay);

}  // namespace risorius
