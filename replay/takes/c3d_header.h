// The first block of a C3D file: 512 bytes that say where the parameters are and repeat the most needed of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "replay/takes/c3d_numbers.h"

namespace risorius {

struct C3dHeader {
  std::uint16_t points = 0;            ///< word 2
  std::uint16_t analog_per_frame = 0;  ///< word 3: analog values in one 3D frame
  std::uint16_t first_frame = 0;       ///< word 4, from 1
  std::uint16_t last_frame = 0;        ///< word 5, inclusive; 65535 where there are more
  float scale = 0;                     ///< words 7-8: negative means that points are floats
  std::uint16_t data_block = 0;        ///< word 9, from 1
  float rate_hz = 0;                   ///< words 11-12
};

/// The block (from 1) at which the parameter section starts. Throws UserError, naming `place`, if the first two bytes
/// are not those of a C3D file.
std::uint8_t c3d_parameter_block(const std::array<std::uint8_t, kC3dBlockBytes>& block, const std::string& place);

C3dHeader decode_c3d_header(const std::array<std::uint8_t, kC3dBlockBytes>& block, C3dProcessor processor) noexcept;

}  // namespace risorius
