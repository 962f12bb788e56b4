// risorius keys: a CURVE key pair for a daemon, or for somebody who connects to one.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "capture/wire/curve_keys.h"
#include "replay/commands/commands.h"

namespace risorius {

void add_keys_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("keys", "make a CURVE key pair, which encrypts ZeroMQ connections");
  auto name = std::make_shared<std::string>();
  command->add_option("name", *name, "writes NAME.key (to give away) and NAME.key_secret (to keep)")->required();
  command->callback([name] {
    write_curve_certificate(*name, make_curve_key_pair());
    fmt::print(
        "{0}.key         to give to those who connect to you, or whom you connect to\n"
        "{0}.key_secret  to keep: readable by you alone\n",
        *name);
  });
}

}  // namespace risorius
