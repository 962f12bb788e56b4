// Texts and messages that describe something (fuzz_target.h).
#pragma once

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

void run_rig(std::span<const std::byte> input);
std::vector<Bytes> rig_seeds();
void run_landmarks(std::span<const std::byte> input);
std::vector<Bytes> landmark_seeds();
void run_config(std::span<const std::byte> input);
std::vector<Bytes> config_seeds();
void run_control(std::span<const std::byte> input);
std::vector<Bytes> control_seeds();

}  // namespace risorius::fuzz
