// The subcommands of risorius-train.
#pragma once

#include <CLI/CLI.hpp>

namespace risorius {

void add_corpus_command(CLI::App& app);
void add_expression_command(CLI::App& app);
void add_continuation_command(CLI::App& app);
void add_seed_command(CLI::App& app);

}  // namespace risorius
