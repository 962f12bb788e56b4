#include "replay/takes/c3d_header.h"

#include "capture/errors.h"

namespace risorius {

std::uint8_t c3d_parameter_block(const std::array<std::uint8_t, kC3dBlockBytes>& block, const std::string& place) {
  constexpr std::uint8_t kC3dKey = 0x50;
  if (block[1] != kC3dKey)
    throw UserError(place, "byte 2 is " + std::to_string(block[1]) + " where every C3D file has 80",
                    "this is no C3D file; export the take again, or give its true extension");
  if (block[0] < 2)
    throw UserError(place, "byte 1 puts the parameter section into block " + std::to_string(block[0]),
                    "it must be 2 or more; the header is damaged, export the take again");
  return block[0];
}

C3dHeader decode_c3d_header(const std::array<std::uint8_t, kC3dBlockBytes>& block, C3dProcessor processor) noexcept {
  // The format counts 16-bit words from 1.
  const auto word_at = [&](std::size_t number) { return block.data() + 2 * (number - 1); };
  const auto word = [&](std::size_t number) { return c3d_word(word_at(number), processor); };
  return {.points = word(2),
          .analog_per_frame = word(3),
          .first_frame = word(4),
          .last_frame = word(5),
          .scale = c3d_float(word_at(7), processor),
          .data_block = word(9),
          .rate_hz = c3d_float(word_at(11), processor)};
}

}  // namespace risorius
