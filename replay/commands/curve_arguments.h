// --curve-server and --curve-key, of the commands that connect to a daemon with CURVE keys.
#pragma once

#include <optional>
#include <string>

#include "capture/wire/curve_keys.h"

namespace CLI {
class App;
}

namespace risorius {

class CurveArguments {
 public:
  void add_to(CLI::App& command);

  /// Nothing if no server key was given. Without a key of our own, one is made for this connection: enough for a server
  /// that keeps no list. Throws UserError naming file and remedy.
  std::optional<CurveClient> client() const;

 private:
  std::string server_file_, own_file_;
};

}  // namespace risorius
