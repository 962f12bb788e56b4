// Options of all stages of a stream, from reorder to continuation, and their TOML tables: the same for the daemon's
// configuration and for `risorius dataset --config`.
#pragma once

#include <filesystem>
#include <string>

#include "capture/wire/reorder_window.h"
#include "replay/pipeline/frame_pipeline.h"
#include "replay/pipeline/toml_fields.h"

namespace risorius {

struct StageConfig {
  ReorderOptions reorder;
  PipelineOptions pipeline;
};

/// Reads the tables [reorder] [despike] [fill] [solve] [continuation] where they are there; collects problems.
void read_stage_tables(TomlReader& reader, StageConfig& stages);
/// Prints them, each key with its range and meaning.
void print_stage_tables(TomlPrinter& printer, const StageConfig& stages);
std::string print_stage_config(const StageConfig& stages);

/// Throw UserError: what is wrong with the file or the text; all problems in one message.
toml::table parse_toml_file(const std::filesystem::path& path);
toml::table parse_toml(std::string_view text, const std::string& place);
void throw_if_any(const ConfigProblems& problems, const std::string& place);

/// The stage tables of a configuration file of the daemon as they hold for the [[source]] named `source` ("" if there
/// is at most one); its other tables are left to the daemon. Throws UserError.
StageConfig load_stage_config(const std::filesystem::path& path, const std::string& source);
/// The same of its text; `place` names it in errors.
StageConfig parse_stage_config(std::string_view toml, const std::string& place, const std::string& source);

}  // namespace risorius
