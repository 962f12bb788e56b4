#include "replay/study/face_data.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <openssl/evp.h>
#include <string>

#include "capture/check.h"
#include "replay/picture/facial_creases.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

using Eigen::Index;

// The camera stands in front of the face; field: height of the picture at the target.
constexpr double kTargetYMm = 20, kTargetZMm = 50, kDistanceMm = 1100, kFieldMm = 256;
constexpr double kTurnedAway = -0.3;  // cosine between a triangle and the way to the camera: never in sight
constexpr double kLeastMoveMm = 0.01;
// The creases' grid over the face at rest, mm: fewer than 65536 cells.
constexpr double kCreaseLeftMm = -80, kCreaseLowMm = -95, kCreaseStepMm = 0.75;
constexpr int kCreaseColumns = 214, kCreaseRows = 260;
constexpr double kCreaseDepthStepMm = 0.0125, kLeastCreaseMm = 0.02, kHandOverMm = 6;

template <class Number>
std::string packed(const std::vector<Number>& values) {
  static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");
  return base64_of(std::as_bytes(std::span(values)));
}

template <class Number>
Number rounded(double value) {
  const long whole = std::lround(value);
  RISORIUS_CHECK(whole >= std::numeric_limits<Number>::min() && whole <= std::numeric_limits<Number>::max());
  return static_cast<Number>(whole);
}

/// What of the mesh is in sight from the front, with its own numbers of vertices.
struct Front {
  std::vector<int> vertices;             ///< of the face's
  std::vector<std::uint16_t> triangles;  ///< three of our vertices each
  std::size_t skin_triangles = 0;
};

Front front_of(const FaceModel& face) {
  Front front;
  const Eigen::Matrix3Xd& vertices = face.vertices_mm();
  std::vector<int> number(static_cast<std::size_t>(vertices.cols()), -1);
  for (Index t = 0; t < face.triangles().cols(); ++t) {
    const Eigen::Vector3i v = face.triangles().col(t);
    const Eigen::Vector3d a = vertices.col(v[0]), b = vertices.col(v[1]), c = vertices.col(v[2]);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const Eigen::Vector3d to_camera = Eigen::Vector3d(0, kTargetYMm, kTargetZMm + kDistanceMm) - (a + b + c) / 3;
    const bool is_skin = t < face.skin_triangle_count();
    // Lids, lips and what is behind them turn; the skin of the head's back does not.
    if (is_skin && normal.dot(to_camera) < kTurnedAway * normal.norm() * to_camera.norm()) continue;
    for (const int corner : v) {
      int& own = number[static_cast<std::size_t>(corner)];
      if (own < 0) {
        own = static_cast<int>(front.vertices.size());
        front.vertices.push_back(corner);
      }
      front.triangles.push_back(rounded<std::uint16_t>(own));
    }
    front.skin_triangles += is_skin ? 1 : 0;
  }
  return front;
}

void add_shape(const FaceModel& face, const Front& front, nlohmann::json& data) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const int v : front.vertices) {
    low = low.cwiseMin(face.vertices_mm().col(v));
    high = high.cwiseMax(face.vertices_mm().col(v));
  }
  const double step_mm = (high - low).maxCoeff() / 65535;
  std::vector<std::uint16_t> places;
  std::vector<std::uint8_t> colours;
  for (const int v : front.vertices) {
    for (Index axis = 0; axis < 3; ++axis) {
      places.push_back(rounded<std::uint16_t>((face.vertices_mm()(axis, v) - low[axis]) / step_mm));
      if (face.colours().cols() > 0)
        colours.push_back(rounded<std::uint8_t>(255 * std::clamp(face.colours()(axis, v), 0.0, 1.0)));
    }
  }
  data["low_mm"] = {low.x(), low.y(), low.z()};
  data["step_mm"] = step_mm;
  data["vertices"] = packed(places);
  data["triangles"] = packed(front.triangles);
  data["skin_triangles"] = front.skin_triangles;
  data["colours"] = packed(colours);
}

nlohmann::json moves_of(const FaceAu& au, const Front& front) {
  const double step_mm = std::max(1e-6, au.displacement_mm.cwiseAbs().maxCoeff()) / 32767;
  std::vector<std::uint16_t> indices;
  std::vector<std::int16_t> moves;
  for (std::size_t k = 0; k < front.vertices.size(); ++k) {
    const Eigen::Vector3d move = au.displacement_mm.col(front.vertices[k]);
    if (move.norm() < kLeastMoveMm) continue;
    indices.push_back(static_cast<std::uint16_t>(k));
    for (const double along : move) moves.push_back(rounded<std::int16_t>(along / step_mm));
  }
  return {{"name", au.name}, {"step_mm", step_mm}, {"indices", packed(indices)}, {"moves", packed(moves)}};
}

/// Creases of one side; those that begin in the middle of the face hand over to their mirror image there.
double crease_height_mm(const CreaseShade& shade, double side, double x_mm, double y_mm) {
  const double share = std::clamp(0.5 + side * x_mm / kHandOverMm, 0.0, 1.0);
  return share > 0 ? share * shade.height_mm(x_mm, y_mm) : 0;
}

/// Depths of the AU's creases where there are any: cell numbers (row by row from the lowest) and heights.
void add_creases(const FaceAu& au, nlohmann::json& data) {
  const auto name = parse_au_name(au.name);
  if (!name) return;
  const std::string number = "AU" + std::to_string(name->number);
  const CreaseShade none;
  const CreaseShade left = name->side == AuSide::kRight ? none : CreaseShade({number + "L"}, 1);
  const CreaseShade right = name->side == AuSide::kLeft ? none : CreaseShade({number + "R"}, 1);
  if (left.empty() && right.empty()) return;
  std::vector<std::uint16_t> cells;
  std::vector<std::int8_t> heights;
  for (int row = 0; row < kCreaseRows; ++row) {
    for (int column = 0; column < kCreaseColumns; ++column) {
      const double x_mm = kCreaseLeftMm + kCreaseStepMm * column, y_mm = kCreaseLowMm + kCreaseStepMm * row;
      const double height_mm = crease_height_mm(left, 1, x_mm, y_mm) + crease_height_mm(right, -1, x_mm, y_mm);
      if (std::abs(height_mm) < kLeastCreaseMm) continue;
      cells.push_back(static_cast<std::uint16_t>(row * kCreaseColumns + column));
      heights.push_back(static_cast<std::int8_t>(std::clamp(std::lround(height_mm / kCreaseDepthStepMm), -127L, 127L)));
    }
  }
  data["crease_cells"] = packed(cells);
  data["crease_heights"] = packed(heights);
}

}  // namespace

std::string base64_of(std::span<const std::byte> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // the library ends it with a zero
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

nlohmann::json face_data(const FaceModel& face, const std::vector<std::string>& aus) {
  nlohmann::json data = nlohmann::json::object();
  const Front front = front_of(face);
  add_shape(face, front, data);
  data["camera"] = {{"target_mm", {0, kTargetYMm, kTargetZMm}}, {"distance_mm", kDistanceMm}, {"field_mm", kFieldMm}};
  data["creases"] = {{"left_mm", kCreaseLeftMm},  {"low_mm", kCreaseLowMm}, {"step_mm", kCreaseStepMm},
                     {"columns", kCreaseColumns}, {"rows", kCreaseRows},    {"height_step_mm", kCreaseDepthStepMm}};
  data["aus"] = nlohmann::json::array();
  const bool has_creases = face.name() == "builtin";  // another face's wrinkles are not known
  for (const std::string& name : aus) {
    const FaceAu* au = face.find_au(name);
    if (au == nullptr) continue;
    nlohmann::json& one = data["aus"].emplace_back(moves_of(*au, front));
    if (has_creases) add_creases(*au, one);
  }
  return data;
}

}  // namespace risorius
