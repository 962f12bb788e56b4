// Protocols over the network, each as a conversation with its session (fuzz_target.h).
#pragma once

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

void run_native(std::span<const std::byte> input);
std::vector<Bytes> native_seeds();
void run_live_link(std::span<const std::byte> input);
std::vector<Bytes> live_link_seeds();
void run_natnet(std::span<const std::byte> input);
std::vector<Bytes> natnet_seeds();
void run_qtm(std::span<const std::byte> input);
std::vector<Bytes> qtm_seeds();
void run_vicon(std::span<const std::byte> input);
std::vector<Bytes> vicon_seeds();

}  // namespace risorius::fuzz
