// The rig file: JSON as specified in solve/README.md.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "capture/errors.h"
#include "solve/rigs/json_depth.h"
#include "solve/rigs/rig.h"

namespace risorius {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kFormat = "risorius-rig";
constexpr int kVersion = 1;

std::string shown(const Json& value) {
  constexpr std::size_t kLongest = 40;
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "...";
}

/// Reads fields out of untrusted JSON and collects every problem instead of stopping at the first.
class FieldReader {
 public:
  const std::vector<std::string>& problems() const noexcept { return problems_; }
  void report(const std::string& field, const std::string& problem) { problems_.push_back(field + ": " + problem); }

  bool expect_object(const Json& value, const std::string& field, std::initializer_list<std::string_view> keys) {
    if (!value.is_object()) {
      report(field, fmt::format("found {}, expected an object", shown(value)));
      return false;
    }
    for (const auto& [key, ignored] : value.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        report(field, fmt::format("unknown key '{}', known are {}", key, fmt::join(keys, ", ")));
      }
    }
    return true;
  }
  /// Null if the key is absent, which is a problem if it is required.
  const Json* member(const Json& object, const std::string& field, const char* key, bool required) {
    const auto found = object.find(key);
    if (found != object.end()) return &*found;
    if (required) report(field, fmt::format("the key '{}' is missing", key));
    return nullptr;
  }
  void read(const Json* value, const std::string& field, std::string& text) {
    if (value == nullptr) return;
    if (value->is_string()) {
      text = value->get<std::string>();
    } else {
      report(field, fmt::format("found {}, expected a string", shown(*value)));
    }
  }
  void read(const Json* value, const std::string& field, double& number) {
    if (value == nullptr) return;
    if (value->is_number()) {
      number = value->get<double>();
    } else {
      report(field, fmt::format("found {}, expected a number", shown(*value)));
    }
  }
  void read_vector(const Json* value, const std::string& field, Eigen::Ref<Eigen::Vector3d> vector) {
    if (value == nullptr) return;
    if (!value->is_array() || value->size() != 3) {
      report(field, fmt::format("found {}, expected [x, y, z] in mm", shown(*value)));
      return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      read(&(*value)[axis], field, vector[static_cast<Eigen::Index>(axis)]);
    }
  }
  const Json* array(const Json& object, const std::string& field, const char* key) {
    const Json* value = member(object, field, key, true);
    if (value == nullptr || value->is_array()) return value;
    report(key, fmt::format("found {}, expected an array", shown(*value)));
    return nullptr;
  }

 private:
  std::vector<std::string> problems_;
};

void read_markers(FieldReader& reader, const Json& markers, Rig& rig) {
  const std::size_t count = markers.size();
  rig.neutral_mm = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(count));
  rig.stabiliser_weight = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count));
  rig.marker_names.resize(count);
  std::vector<double> fit_distance_mm(count);
  std::size_t with_distance = 0;
  for (std::size_t m = 0; m < count; ++m) {
    const std::string field = fmt::format("markers[{}]", m);
    const Json& marker = markers[m];
    const Eigen::Index column = static_cast<Eigen::Index>(m);
    if (!reader.expect_object(marker, field, {"name", "neutral_mm", "stabiliser_weight", "fit_distance_mm"})) continue;
    reader.read(reader.member(marker, field, "name", true), field + ".name", rig.marker_names[m]);
    reader.read_vector(reader.member(marker, field, "neutral_mm", true), field + ".neutral_mm",
                       rig.neutral_mm.col(column));
    reader.read(reader.member(marker, field, "stabiliser_weight", false), field + ".stabiliser_weight",
                rig.stabiliser_weight[column]);
    const Json* distance = reader.member(marker, field, "fit_distance_mm", false);
    reader.read(distance, field + ".fit_distance_mm", fit_distance_mm[m]);
    with_distance += distance != nullptr;
  }
  if (with_distance == count) rig.fit_distance_mm = std::move(fit_distance_mm);
  if (with_distance != 0 && with_distance != count) {
    reader.report("markers", fmt::format("fit_distance_mm stands at {} of {} markers, give it at all or none",
                                         with_distance, count));
  }
}

RigAu read_au(FieldReader& reader, const Json& au, const std::string& field, std::size_t marker_count) {
  RigAu result;
  if (!reader.expect_object(au, field, {"name", "upper_bound", "displacement_mm"})) return result;
  reader.read(reader.member(au, field, "name", true), field + ".name", result.name);
  reader.read(reader.member(au, field, "upper_bound", false), field + ".upper_bound", result.upper_bound);
  const Json* rows = reader.array(au, field, "displacement_mm");
  if (rows == nullptr) return result;
  if (rows->size() != marker_count) {
    reader.report(
        field + ".displacement_mm",
        fmt::format("{} entries for {} markers, expected one [x, y, z] per marker", rows->size(), marker_count));
    return result;
  }
  result.displacement_mm = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(marker_count));
  for (std::size_t m = 0; m < marker_count; ++m) {
    reader.read_vector(&(*rows)[m], fmt::format("{}.displacement_mm[{}]", field, m),
                       result.displacement_mm.col(static_cast<Eigen::Index>(m)));
  }
  return result;
}

bool is_rig_of_this_version(FieldReader& reader, const Json& root) {
  if (!root.is_object() || root.value("format", Json()) != Json(kFormat)) {
    reader.report("format", fmt::format("not a rig file, expected \"format\": \"{}\"", kFormat));
    return false;
  }
  const Json version = root.value("version", Json());
  if (version == Json(kVersion)) return true;
  reader.report("version", fmt::format("found {}, this program reads version {}", shown(version), kVersion));
  return false;
}

Rig read_rig(FieldReader& reader, const Json& root) {
  Rig rig;
  if (!is_rig_of_this_version(reader, root)) return rig;
  reader.expect_object(root, "the file", {"format", "version", "name", "facs_edition", "source", "markers", "aus"});
  reader.read(reader.member(root, "the file", "name", true), "name", rig.name);
  reader.read(reader.member(root, "the file", "facs_edition", false), "facs_edition", rig.facs_edition);
  reader.read(reader.member(root, "the file", "source", false), "source", rig.source);
  if (const Json* markers = reader.array(root, "the file", "markers")) read_markers(reader, *markers, rig);
  if (const Json* aus = reader.array(root, "the file", "aus")) {
    for (std::size_t i = 0; i < aus->size(); ++i) {
      rig.aus.push_back(read_au(reader, (*aus)[i], fmt::format("aus[{}]", i), rig.marker_count()));
    }
  }
  return rig;
}

Json vector_to_json(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

[[noreturn]] void throw_file_error(const std::filesystem::path& path, const char* problem, const char* remedy) {
  throw UserError(path.string(), problem, remedy);
}

}  // namespace

Rig parse_rig(std::string_view json, const std::string& place) {
  if (nests_too_deep(json))
    throw UserError(place, "nests too deep for a rig", "see solve/README.md for the rig format");
  Json root;
  try {
    root = Json::parse(json);
  } catch (const Json::exception& error) {
    throw UserError(place, std::string("not valid JSON: ") + error.what(), "see solve/README.md for the rig format");
  }
  FieldReader reader;
  Rig rig = read_rig(reader, root);
  std::vector<std::string> problems = reader.problems();
  if (problems.empty()) problems = problems_of(rig);
  if (!problems.empty()) {
    throw UserError(place, fmt::format("{}", fmt::join(problems, "; ")), "correct the rig file, see solve/README.md");
  }
  return rig;
}

Rig load_rig(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) {
    throw UserError(path.string(), "is a folder", "give the path of a rig file (JSON)");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw_file_error(path, "the rig file cannot be opened", "check the path and its permissions");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw_file_error(path, "the rig file cannot be read", "check the disk");
  return parse_rig(text, path.string());
}

std::string rig_to_json(const Rig& rig) {
  Json root = {{"format", kFormat},
               {"version", kVersion},
               {"name", rig.name},
               {"facs_edition", rig.facs_edition},
               {"source", rig.source}};
  Json& markers = root["markers"] = Json::array();
  for (std::size_t m = 0; m < rig.marker_count(); ++m) {
    const Eigen::Index column = static_cast<Eigen::Index>(m);
    Json marker = {{"name", rig.marker_names[m]},
                   {"neutral_mm", vector_to_json(rig.neutral_mm.col(column))},
                   {"stabiliser_weight", rig.stabiliser_weight[column]}};
    if (!rig.fit_distance_mm.empty()) marker["fit_distance_mm"] = rig.fit_distance_mm[m];
    markers.push_back(std::move(marker));
  }
  Json& aus = root["aus"] = Json::array();
  for (const RigAu& au : rig.aus) {
    Json rows = Json::array();
    for (Eigen::Index m = 0; m < au.displacement_mm.cols(); ++m)
      rows.push_back(vector_to_json(au.displacement_mm.col(m)));
    aus.push_back({{"name", au.name}, {"upper_bound", au.upper_bound}, {"displacement_mm", std::move(rows)}});
  }
  return root.dump(1) + "\n";
}

void save_rig(const Rig& rig, const std::filesystem::path& path) {
  if (const std::vector<std::string> problems = problems_of(rig); !problems.empty()) {
    throw UserError(path.string(), fmt::format("the rig is not valid: {}", fmt::join(problems, "; ")), "");
  }
  const std::string text = rig_to_json(rig);
  std::filesystem::path partial = path;
  partial += fmt::format(".partial-{}", ::getpid());
  std::ofstream file(partial, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(partial, path, error);
  if (!file || error) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw_file_error(path, "the rig file cannot be written", "check that the folder exists and the disk has room");
  }
}

}  // namespace risorius
