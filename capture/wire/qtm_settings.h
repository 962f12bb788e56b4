// What QTM says about itself in XML, as far as it concerns markers (GetParameters 3D and General), in both directions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/marker_set.h"

namespace risorius {

struct QtmSettings {
  std::optional<std::vector<std::string>> labels;  ///< of the 3D component, in its order; empty if no 3D section
  std::optional<double> frequency_hz;              ///< of the cameras
  std::optional<double> timecode_rate_hz;          ///< of an external time stamp that is enabled
  std::string axis_upwards;                        ///< "+Z" and so on; "" if not stated
};

/// Tolerant of whatever else the document has, of its root's name, and of a wrong label count. Empty if it is no XML.
std::optional<QtmSettings> parse_qtm_settings(std::string_view xml);

/// The document as QTM writes it for GetParameters with the sections asked for. `version` as in "1.13".
std::string print_qtm_settings(const QtmSettings& settings, std::string_view version);

/// QTM says only which axis is up ("+Z" and so on; anything else is taken for that). Right-handed, for a subject who
/// looks along the first horizontal axis; which way he really looks is head pose.
Axes qtm_axes(std::string_view upwards);

}  // namespace risorius
