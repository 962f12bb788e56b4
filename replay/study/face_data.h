// A face as the study's page draws it: quantised, as JSON with binary fields in base64 (README.md, "The study's page").
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "solve/faces/face_model.h"

namespace risorius {

/// Of these AUs only; names that the face does not have are left out. What a camera in front never sees (the back of
/// the head) is left out, too. Positions are rounded to less than 0.01 mm, displacements to less than 0.001 mm.
nlohmann::json face_data(const FaceModel& face, const std::vector<std::string>& aus);

/// Standard base64 with padding (RFC 4648).
std::string base64_of(std::span<const std::byte> bytes);

}  // namespace risorius
