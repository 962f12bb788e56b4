// What a recorded session is read with (fuzz_target.h): its MCAP file, and the Ticks in it.
#pragma once

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

void run_mcap(std::span<const std::byte> input);
std::vector<Bytes> mcap_seeds();
void run_tick(std::span<const std::byte> input);
std::vector<Bytes> tick_seeds();

}  // namespace risorius::fuzz
