#include "capture/wire/qtm_settings.h"

#include <array>
#include <cmath>
#include <pugixml.hpp>
#include <span>
#include <sstream>
#include <utility>

namespace risorius {
namespace {

std::optional<double> positive(const pugi::xml_text& text) {
  const double value = text.as_double();
  return std::isfinite(value) && value > 0 ? std::optional(value) : std::nullopt;
}

/// The element, wherever it is below `node` at depth 0 or 1: clients have been sent sections without a root too.
pugi::xml_node section(const pugi::xml_document& document, const char* name) {
  if (const auto direct = document.child(name)) return direct;
  for (const auto root : document.children())
    if (const auto found = root.child(name)) return found;
  return {};
}

pugi::xml_node add(pugi::xml_node parent, const char* name, const std::string& text) {
  auto child = parent.append_child(name);
  child.text().set(text.c_str());
  return child;
}

std::string plain_number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

using NameAndValue = std::pair<const char*, const char*>;

// Clients take the whole section for unreadable if one of these is missing or in another order.
constexpr std::array<NameAndValue, 5> kNoTriggers{{{"Capture_Time", "0.000"},
                                                   {"Start_On_External_Trigger", "False"},
                                                   {"Start_On_Trigger_NO", "False"},
                                                   {"Start_On_Trigger_NC", "False"},
                                                   {"Start_On_Trigger_Software", "False"}}};
constexpr std::array<NameAndValue, 10> kNoTimeBase{{{"Enabled", "False"},
                                                    {"Signal_Source", "Control port"},
                                                    {"Signal_Mode", "Periodic"},
                                                    {"Frequency_Multiplier", "1"},
                                                    {"Frequency_Divisor", "1"},
                                                    {"Frequency_Tolerance", "1000"},
                                                    {"Nominal_Frequency", "None"},
                                                    {"Signal_Edge", "Negative"},
                                                    {"Signal_Shutter_Delay", "0"},
                                                    {"Non_Periodic_Timeout", "0"}}};

// The same holds for what QTM would do with a recording.
constexpr std::array<const char*, 12> kProcessing{
    "PreProcessing2D", "Tracking",  "TwinSystemMerge", "SplineFill",       "AIM",          "Track6DOF", "ForceData",
    "GazeVector",      "ExportTSV", "ExportC3D",       "ExportMatlabFile", "ExportAviFile"};
constexpr std::array<const char*, 6> kLiveProcessing{"PreProcessing2D", "Tracking",  "AIM",
                                                     "Track6DOF",       "ForceData", "GazeVector"};
// A take does not know when its system was calibrated, and clients refuse an empty date.
constexpr const char* kNoCalibrationTime = "1970.01.01 00:00:00";

void add_no_actions(pugi::xml_node general, const char* name, std::span<const char* const> actions) {
  auto section = general.append_child(name);
  for (const char* action : actions) add(section, action, "False");
}

void add_all(pugi::xml_node parent, std::span<const NameAndValue> entries) {
  for (const auto& [name, value] : entries) add(parent, name, value);
}

}  // namespace

std::optional<QtmSettings> parse_qtm_settings(std::string_view xml) {
  pugi::xml_document document;
  if (!document.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8)) return {};
  QtmSettings settings;
  if (const auto general = section(document, "General")) {
    settings.frequency_hz = positive(general.child("Frequency").text());
    const auto stamp = general.child("External_Timestamp");
    if (std::string_view(stamp.child_value("Enabled")) == "True")
      settings.timecode_rate_hz = positive(stamp.child("Frequency").text());
  }
  if (const auto markers = section(document, "The_3D")) {
    settings.axis_upwards = markers.child_value("AxisUpwards");
    settings.labels.emplace();
    for (const auto label : markers.children("Label")) settings.labels->emplace_back(label.child_value("Name"));
  }
  return settings;
}

std::string print_qtm_settings(const QtmSettings& settings, std::string_view version) {
  pugi::xml_document document;
  auto root = document.append_child(("QTM_Parameters_Ver_" + std::string(version)).c_str());
  if (settings.frequency_hz) {
    auto general = root.append_child("General");
    // Whole Hertz, as QTM gives it: clients read an integer.
    add(general, "Frequency", plain_number(std::round(*settings.frequency_hz)));
    add_all(general, kNoTriggers);
    add_all(general.append_child("External_Time_Base"), kNoTimeBase);
    if (settings.timecode_rate_hz) {
      auto stamp = general.append_child("External_Timestamp");
      add(stamp, "Enabled", "True");
      add(stamp, "Type", "SMPTE");
      add(stamp, "Frequency", plain_number(std::round(*settings.timecode_rate_hz)));
    }
    add_no_actions(general, "Processing_Actions", kProcessing);
    add_no_actions(general, "RealTime_Processing_Actions", kLiveProcessing);
    add_no_actions(general, "Reprocessing_Actions", kProcessing);
  }
  if (settings.labels) {
    auto markers = root.append_child("The_3D");
    add(markers, "AxisUpwards", settings.axis_upwards);
    add(markers, "CalibrationTime", kNoCalibrationTime);
    add(markers, "Labels", std::to_string(settings.labels->size()));
    for (const std::string& name : *settings.labels) {
      auto label = markers.append_child("Label");
      add(label, "Name", name);
      add(label, "RGBColor", "65280");
      add(label, "Trajectory_Type", "Measured");
    }
  }
  std::ostringstream text;
  document.save(text, "    ", pugi::format_default | pugi::format_no_declaration, pugi::encoding_utf8);
  return text.str();
}

Axes qtm_axes(std::string_view upwards) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kAxes{
      {{"+X", "UFL"}, {"-X", "DFR"}, {"+Y", "LUF"}, {"-Y", "RDF"}, {"+Z", "FLU"}, {"-Z", "FRD"}}};
  for (const auto& [up, letters] : kAxes)
    if (up == upwards) return *Axes::parse(letters);
  return *Axes::parse("FLU");
}

}  // namespace risorius
