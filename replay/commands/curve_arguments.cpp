#include "replay/commands/curve_arguments.h"

#include <CLI/CLI.hpp>

#include "capture/errors.h"

namespace risorius {

void CurveArguments::add_to(CLI::App& command) {
  command.add_option("--curve-server", server_file_, "the daemon's .key file, if it has CURVE keys");
  command.add_option("--curve-key", own_file_, "our .key_secret file, if the daemon keeps a list of clients");
}

std::optional<CurveClient> CurveArguments::client() const {
  if (server_file_.empty()) {
    if (own_file_.empty()) return std::nullopt;
    throw UserError("--curve-key", "without --curve-server there is nobody to trust",
                    "give --curve-server the daemon's .key file");
  }
  return CurveClient{.keys = own_file_.empty() ? make_curve_key_pair() : load_curve_secret(own_file_),
                     .server_public_key = load_curve_public(server_file_)};
}

}  // namespace risorius
