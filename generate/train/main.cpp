// risorius-train: makes the generators' weights. The daemon and the tool never link it.
#include <CLI/CLI.hpp>
#include <exception>
#include <fmt/format.h>

#include "capture/version.h"
#include "generate/train/commands.h"
#include "replay/unfinished_paths.h"

int main(int argc, char** argv) {
  CLI::App app("Risorius: trains the generators. Weights go to generate/weights/.");
  app.set_version_flag("--version", fmt::format("risorius-train {}", risorius::kVersion));
  app.require_subcommand(1);
  risorius::add_corpus_command(app);
  risorius::add_expression_command(app);
  risorius::add_continuation_command(app);
  risorius::add_seed_command(app);
  risorius::remove_unfinished_paths_on_signals();
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "risorius-train: {}\n", error.what());
    return 1;
  }
}
