// A trained network as a safetensors file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <torch/torch.h>

namespace risorius {

/// All parameters by their names, as bf16. The file appears complete or not at all. Throws UserError.
void export_weights(const torch::nn::Module& network, std::map<std::string, std::string> metadata,
                    const std::filesystem::path& path);

/// Rounds all parameters to what bf16 keeps, so that figures measured afterwards are the exported file's.
void round_weights(torch::nn::Module& network);

}  // namespace risorius
