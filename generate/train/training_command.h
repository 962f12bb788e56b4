// What the subcommands that train have in common: their options, and what becomes of the trained network.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <torch/torch.h>

#include "generate/train/training_run.h"

namespace risorius {

struct TrainingArguments {
  std::string recording, out = "build/train";
  TrainingOptions training;

  std::optional<std::filesystem::path> recording_path() const;
};

/// --out, --steps, --seed, --rate and --decay, with what `arguments` holds as their defaults.
void add_training_options(CLI::App& command, TrainingArguments& arguments);
/// --recording: alex_rom_3.csv.
void add_recording_option(CLI::App& command, TrainingArguments& arguments);

/// Called before anything is drawn: one thread, since sums over several depend on their number.
void begin_training(const TrainingOptions& options);

/// Rounds the weights to what is exported, prints `measure`'s figures of them, writes NAME.safetensors into the
/// training's folder and prints its path. `metadata`: all but "model", which is the training's name. Throws UserError.
void finish_training(torch::nn::Module& network, const TrainingOptions& options,
                     const std::function<Measurements()>& measure, std::map<std::string, std::string> metadata);

}  // namespace risorius
