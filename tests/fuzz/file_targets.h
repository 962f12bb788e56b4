// Readers of recorded files (fuzz_target.h).
#pragma once

#include "fuzz/fuzz_target.h"

namespace risorius::fuzz {

void run_c3d(std::span<const std::byte> input);
std::vector<Bytes> c3d_seeds();
void run_trc(std::span<const std::byte> input);
std::vector<Bytes> trc_seeds();
void run_csv(std::span<const std::byte> input);
std::vector<Bytes> csv_seeds();
void run_iemocap(std::span<const std::byte> input);
std::vector<Bytes> iemocap_seeds();
void run_kinect(std::span<const std::byte> input);
std::vector<Bytes> kinect_seeds();
void run_bnd(std::span<const std::byte> input);
std::vector<Bytes> bnd_seeds();
void run_au_csv(std::span<const std::byte> input);
std::vector<Bytes> au_csv_seeds();
void run_live_link_csv(std::span<const std::byte> input);
std::vector<Bytes> live_link_csv_seeds();

void run_safetensors(std::span<const std::byte> input);
std::vector<Bytes> safetensors_seeds();

}  // namespace risorius::fuzz
