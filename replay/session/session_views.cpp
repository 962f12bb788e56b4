#include "replay/session/session_views.h"

#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

namespace risorius {
namespace {

// Viewers know plain types only, and of an object no more than the properties that its schema lists: a `type` that is a
// list, or an object without `properties`, makes Foxglove refuse the topic.
constexpr std::string_view kAuViewSchema = R"json({
"description": "FACS action units of one frame, decimated to 60 Hz; what was not observed is left out", "type": "object",
"properties": {
"timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
"stream": {"type": "string"}, "sequence": {"type": "integer"}, "kind": {"type": "string"}, "status": {"type": "string"},
"residual_rms_mm": {"type": "number"},
"au": {"type": "object", "properties": {}}}})json";

constexpr std::string_view kMarkerViewSchema = R"json({
"title": "foxglove.PointCloud", "description": "Markers of one frame, decimated to 60 Hz", "type": "object",
"properties": {
"timestamp": {"type": "object", "title": "time",
 "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999999999}}},
"frame_id": {"type": "string"},
"pose": {"type": "object", "title": "foxglove.Pose", "properties": {
 "position": {"type": "object", "title": "foxglove.Vector3",
  "properties": {"x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}}},
 "orientation": {"type": "object", "title": "foxglove.Quaternion",
  "properties": {"x": {"type": "number"}, "y": {"type": "number"}, "z": {"type": "number"}, "w": {"type": "number"}}}}},
"point_stride": {"type": "integer", "minimum": 0},
"fields": {"type": "array", "items": {"type": "object", "title": "foxglove.PackedElementField", "properties": {
 "name": {"type": "string"}, "offset": {"type": "integer", "minimum": 0},
 "type": {"title": "foxglove.NumericType", "oneOf": [{"title": "UINT8", "const": 1}, {"title": "FLOAT32", "const": 7}]}}}},
"data": {"type": "string", "contentEncoding": "base64"}}})json";

constexpr std::uint8_t kFoxgloveUint8 = 1, kFoxgloveFloat32 = 7;
constexpr float kMetresPerMm = 0.001F;
/// x and w of the quaternion of a quarter turn about x: our y is up, viewers' z.
constexpr double kQuarterTurn = std::numbers::sqrt2 / 2;

nlohmann::json time_json(std::int64_t utc_ns) {
  return {{"sec", utc_ns / 1'000'000'000}, {"nsec", utc_ns % 1'000'000'000}};
}

/// Null if it cannot be read.
nlohmann::json decoded(std::span<const std::byte> msgpack) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(msgpack.data());
  auto json = nlohmann::json::from_msgpack(begin, begin + msgpack.size(), true, false);
  return json.is_object() ? json : nlohmann::json();
}

std::string base64(const std::string& bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      triple = triple << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kLetters[triple >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

std::string packed_points(const nlohmann::json& positions_mm, const std::string& states) {
  std::string bytes;
  for (std::size_t m = 0; m < states.size() && 3 * m + 2 < positions_mm.size(); ++m) {
    if (!positions_mm[3 * m].is_number()) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const float metres = positions_mm[3 * m + i].get<float>() * kMetresPerMm;
      bytes.append(reinterpret_cast<const char*>(&metres), sizeof metres);
    }
    bytes += states[m];
  }
  return bytes;
}

}  // namespace

std::string au_view_schema(const std::vector<std::string>& au_names) {
  auto schema = nlohmann::json::parse(kAuViewSchema);
  for (const std::string& name : au_names) schema["properties"]["au"]["properties"][name] = {{"type", "number"}};
  return schema.dump();
}
std::string_view marker_view_schema() { return kMarkerViewSchema; }

std::string au_view_json(std::span<const std::byte> msgpack, std::int64_t utc_ns) {
  const nlohmann::json message = decoded(msgpack);
  if (!message.contains("au") || !message.at("au").is_object()) return {};
  nlohmann::json view{{"timestamp", time_json(utc_ns)}};
  for (const char* key : {"stream", "sequence", "kind", "status", "residual_rms_mm", "au"}) {
    if (message.contains(key) && !message.at(key).is_null()) view[key] = message.at(key);
  }
  std::erase_if(*view["au"].get_ptr<nlohmann::json::object_t*>(), [](const auto& au) { return au.second.is_null(); });
  return view.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string marker_view_json(std::span<const std::byte> msgpack, std::int64_t utc_ns) {
  const nlohmann::json message = decoded(msgpack);
  if (!message.contains("positions_mm") || !message.contains("states")) return {};
  nlohmann::json fields = nlohmann::json::array();
  for (const char* name : {"x", "y", "z"})
    fields.push_back({{"name", name}, {"offset", 4 * fields.size()}, {"type", kFoxgloveFloat32}});
  fields.push_back({{"name", "state"}, {"offset", 12}, {"type", kFoxgloveUint8}});
  const nlohmann::json view{
      {"timestamp", time_json(utc_ns)},
      {"frame_id", "world"},
      {"pose",
       {{"position", {{"x", 0}, {"y", 0}, {"z", 0}}},
        {"orientation", {{"x", kQuarterTurn}, {"y", 0}, {"z", 0}, {"w", kQuarterTurn}}}}},
      {"point_stride", 13},
      {"fields", fields},
      {"data", base64(packed_points(message.at("positions_mm"), message.at("states").get<std::string>()))}};
  return view.dump();
}

}  // namespace risorius
