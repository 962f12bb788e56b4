// The header and parameter section that C3dWriter puts before its frames. Their size depends on the marker set alone,
// so that they can be written first and again when the number of frames is known.
#pragma once

#include <cstdint>
#include <string>

#include "capture/marker_set.h"

namespace risorius {

/// Whole blocks of 512 bytes: header and parameters of an Intel float C3D file in mm.
std::string encode_c3d_preamble(const MarkerSet& markers, const std::string& software_version,
                                std::uint64_t frame_count);

/// Appends a number as Intel C3D stores it.
void append_c3d_word(std::string& bytes, std::uint16_t value);
void append_c3d_float(std::string& bytes, float value);

}  // namespace risorius
