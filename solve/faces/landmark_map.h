// Which markers of a layout sit on which landmarks of a face, and which of them hold the head still. A JSON file:
//   {"format": "risorius-landmarks", "version": 1, "name": "mylab41",
//    "landmarks": {"mouth_corner_left": "Mouth_Lend", ...},     landmark of the face model -> marker
//    "stabilisers": {"ForeHead_M": 1, ...}}                     marker -> weight > 0; may be absent
// Landmarks that a face has: brow_{inner,middle,outer}_{left,right}, eye_{inner,outer}_{left,right}, nose_bridge,
// nose_tip, mouth_corner_{left,right}, lip_upper, lip_lower, chin. Left is the subject's left.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace risorius {

struct LandmarkMap {
  std::string name;
  std::map<std::string, std::string> marker_of_landmark;
  std::map<std::string, double> stabiliser_weight;  ///< by marker
};

/// Throws UserError naming `place`, field, value and remedy.
LandmarkMap parse_landmark_map(std::string_view json, const std::string& place);
LandmarkMap load_landmark_map(const std::filesystem::path& path);

/// A map shipped with the program ("iemocap55", "animface41", "bu4dfe83", "ibug68"), or a file. Throws UserError.
LandmarkMap find_landmark_map(const std::string& name_or_path);

}  // namespace risorius
