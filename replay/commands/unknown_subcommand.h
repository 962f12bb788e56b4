// CLI11 answers an unknown subcommand with "A subcommand is required"; people want to know which ones there are.
#pragma once

namespace CLI {
class App;
}

namespace risorius {

/// Throws UserError naming the word and the subcommands that there are.
void refuse_unknown_subcommand(const CLI::App& app, int argc, const char* const* argv);

}  // namespace risorius
