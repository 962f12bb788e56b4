#include "solve/faces/ict_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

// MeshIO.hh must come before the mesh type.
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "capture/errors.h"

namespace risorius {
namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble>;

constexpr double kMmPerCm = 10;
constexpr double kFarthestCm = 100;
constexpr std::size_t kFaceCount = 52'220;  // after OpenMesh has cut the quads
constexpr std::string_view kNeutralName = "generic_neutral_mesh";
constexpr std::string_view kReleaseHint = "take the folder FaceXModel of the ICT-FaceKit release";

struct Term {
  std::string_view shape;  ///< without "_L", "_R" if the recipe has sides
  double weight = 0;
};

struct Recipe {
  std::string_view au;
  bool has_sides;
  std::array<Term, 2> terms;
};

// FACS 2002 numbers. AU6: cheekSquint and cheekRaiser look the same to markers (cosine 0.985), so their mean is one
// column. AU27 is the whole range of the jaw, AU26 its first 0.6. mouthClose is left out: it only undoes jawOpen.
constexpr std::array kRecipes = std::to_array<Recipe>({
    {"AU1", true, {{{"browInnerUp", 1}}}},
    {"AU2", true, {{{"browOuterUp", 1}}}},
    {"AU4", true, {{{"browDown", 1}}}},
    {"AU5", true, {{{"eyeWide", 1}}}},
    {"AU6", true, {{{"cheekSquint", 0.5}, {"cheekRaiser", 0.5}}}},
    {"AU7", true, {{{"eyeSquint", 1}}}},
    {"AU9", true, {{{"noseSneer", 1}}}},
    {"AU10", true, {{{"mouthUpperUp", 1}}}},
    {"AU12", true, {{{"mouthSmile", 1}}}},
    {"AU14", true, {{{"mouthDimple", 1}}}},
    {"AU15", true, {{{"mouthFrown", 1}}}},
    {"AU16", true, {{{"mouthLowerDown", 1}}}},
    {"AU17", false, {{{"mouthShrugLower", 1}, {"mouthShrugUpper", 0.5}}}},
    {"AU18", false, {{{"mouthPucker", 1}}}},
    {"AU20", true, {{{"mouthStretch", 1}}}},
    {"AU22", false, {{{"mouthFunnel", 1}}}},
    {"AU24", true, {{{"mouthPress", 1}}}},
    {"AU27", false, {{{"jawOpen", 1}}}},
    {"AU28", false, {{{"mouthRollLower", 1}, {"mouthRollUpper", 1}}}},
    {"AU29", false, {{{"jawForward", 1}}}},
    {"AU30L", false, {{{"jawLeft", 1}}}},
    {"AU30R", false, {{{"jawRight", 1}}}},
    {"AU34", true, {{{"cheekPuff", 1}}}},
    {"AU45", true, {{{"eyeBlink", 1}}}},
    {"mouthLeft", false, {{{"mouthLeft", 1}}}},
    {"mouthRight", false, {{{"mouthRight", 1}}}},
});

// Vertices of the published mesh, found by their place: midline extremes, corners of the eye and mouth openings, ends
// of the brows.
constexpr std::array kLandmarkVertices = std::to_array<std::pair<std::string_view, int>>({
    {"brow_inner_left", 3615},
    {"brow_inner_right", 1401},
    {"brow_middle_left", 4114},
    {"brow_middle_right", 1914},
    {"brow_outer_left", 2509},
    {"brow_outer_right", 268},
    {"eye_inner_left", 3742},
    {"eye_inner_right", 1528},
    {"eye_outer_left", 3721},
    {"eye_outer_right", 1507},
    {"nose_bridge", 978},
    {"nose_tip", 4857},
    {"mouth_corner_left", 6213},
    {"mouth_corner_right", 5708},
    {"lip_upper", 0},
    {"lip_lower", 5518},
    {"chin", 963},
});

/// The columns of a recipe: (name, shapes with weights), one or two.
using Column = std::pair<std::string, std::vector<std::pair<std::string, double>>>;

std::vector<Column> columns_of(const Recipe& recipe) {
  std::vector<Column> columns;
  const auto add = [&](const std::string& au_side, const std::string& shape_side) {
    Column column{std::string(recipe.au) + au_side, {}};
    for (const Term& term : recipe.terms) {
      if (term.weight != 0) column.second.emplace_back(std::string(term.shape) + shape_side, term.weight);
    }
    columns.push_back(std::move(column));
  };
  if (recipe.has_sides) {
    add("L", "_L");
    add("R", "_R");
  } else {
    add("", "");
  }
  return columns;
}

std::filesystem::path path_of(const std::filesystem::path& folder, std::string_view shape) {
  return folder / (std::string(shape) + ".obj");
}

void require_files(const std::filesystem::path& folder, const std::vector<std::string>& shapes) {
  std::string missing;
  for (const std::string& shape : shapes) {
    if (!std::filesystem::is_regular_file(path_of(folder, shape))) missing += " " + shape + ".obj";
  }
  if (!missing.empty())
    throw UserError(folder.string(), "ICT-FaceKit files are missing:" + missing, std::string(kReleaseHint));
}

/// OpenMesh reports to stderr what it thinks of a file (such as the material library, which is not published with it);
/// a library stays silent.
class OpenMeshSilence {
 public:
  OpenMeshSilence() { omerr().disable(), omout().disable(); }
  ~OpenMeshSilence() { omerr().enable(), omout().enable(); }
  OpenMeshSilence(const OpenMeshSilence&) = delete;
  OpenMeshSilence& operator=(const OpenMeshSilence&) = delete;
};

/// The file's text; of an expression only the vertex lines, because its faces are the neutral's and building them again
/// is most of the work.
std::stringstream text_of(const std::filesystem::path& path, bool has_faces) {
  std::ifstream file(path);
  std::stringstream text;
  for (std::string line; std::getline(file, line);) {
    if (has_faces || line.starts_with("v ")) text << line << '\n';
  }
  return text;
}

/// OpenMesh keeps the order of an OBJ's vertices and appends copies for faces that are not manifold.
Mesh read_mesh(const std::filesystem::path& path, bool has_faces) {
  const OpenMeshSilence silence;
  std::stringstream text = text_of(path, has_faces);
  OpenMesh::IO::Options options;
  Mesh mesh;
  if (!OpenMesh::IO::read_mesh(mesh, text, ".obj", options)) {
    throw UserError(path.string(), "not an OBJ file", std::string(kReleaseHint));
  }
  if (mesh.n_vertices() != static_cast<std::size_t>(kIctVertexCount)) {
    throw UserError(path.string(),
                    std::to_string(mesh.n_vertices()) + " vertices instead of " + std::to_string(kIctVertexCount),
                    std::string(kReleaseHint));
  }
  return mesh;
}

void require_head(const Mesh& mesh, bool has_faces, const std::filesystem::path& path) {
  if (has_faces && mesh.n_faces() != kFaceCount) {
    throw UserError(path.string(),
                    std::to_string(mesh.n_faces()) + " triangles instead of " + std::to_string(kFaceCount),
                    std::string(kReleaseHint));
  }
  for (const auto vertex : mesh.vertices()) {
    const auto& p = mesh.point(vertex);
    if (std::ranges::all_of(p, [](double cm) { return std::abs(cm) <= kFarthestCm; })) continue;  // no NaN either
    throw UserError(path.string(),
                    fmt::format("vertex {} is at {:g} {:g} {:g} cm, farther than {:g} cm", vertex.idx() + 1, p[0], p[1],
                                p[2], kFarthestCm),
                    std::string(kReleaseHint));
  }
}

Eigen::Matrix3Xd vertices_mm_of(const Mesh& mesh) {
  Eigen::Matrix3Xd vertices_mm(3, kIctVertexCount);
  for (int v = 0; v < kIctVertexCount; ++v) {
    const auto& p = mesh.point(OpenMesh::VertexHandle(v));
    vertices_mm.col(v) = kMmPerCm * Eigen::Vector3d(p[0], p[1], p[2]);
  }
  return vertices_mm;
}

/// The triangles of the face area first.
void add_triangles(const Mesh& mesh, FaceParts& parts) {
  std::vector<Eigen::Vector3i> triangles;
  triangles.reserve(mesh.n_faces());
  for (const auto face : mesh.faces()) {
    Eigen::Vector3i triangle;
    int corner = 0;
    for (const auto vertex : mesh.fv_range(face)) triangle[corner++] = vertex.idx();
    triangles.push_back(triangle);
  }
  const auto is_skin = [](const Eigen::Vector3i& t) { return t.maxCoeff() < kIctFaceVertexCount; };
  const auto skin_end = std::stable_partition(triangles.begin(), triangles.end(), is_skin);
  parts.skin_triangle_count = static_cast<int>(skin_end - triangles.begin());
  parts.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) parts.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
}

}  // namespace

std::vector<std::string> ict_shape_names() {
  std::vector<std::string> names;
  for (const Recipe& recipe : kRecipes) {
    for (const Column& column : columns_of(recipe)) {
      for (const auto& [shape, weight] : column.second) names.push_back(shape);
    }
  }
  return names;
}

FaceModel load_ict_face(const std::filesystem::path& folder, const LoadProgress& progress) {
  std::vector<std::string> files = ict_shape_names();
  files.insert(files.begin(), std::string(kNeutralName));
  require_files(folder, files);
  std::size_t files_read = 0;
  const auto read = [&](std::string_view shape) {
    const bool has_faces = shape == kNeutralName;
    Mesh mesh = read_mesh(path_of(folder, shape), has_faces);
    require_head(mesh, has_faces, path_of(folder, shape));
    ++files_read;
    if (progress) progress(files_read, files.size());
    return mesh;
  };

  FaceParts parts;
  parts.name = "ICT-FaceKit generic face";
  const Mesh neutral = read(kNeutralName);
  parts.vertices_mm = vertices_mm_of(neutral);
  add_triangles(neutral, parts);
  for (const auto& [name, vertex] : kLandmarkVertices) {
    parts.landmarks.emplace(name, place_of_vertex(parts.triangles, vertex));
  }
  for (const Recipe& recipe : kRecipes) {
    for (const Column& column : columns_of(recipe)) {
      FaceAu au{column.first, Eigen::Matrix3Xd::Zero(3, kIctVertexCount)};
      for (const auto& [shape, weight] : column.second) {
        au.displacement_mm += weight * (vertices_mm_of(read(shape)) - parts.vertices_mm);
      }
      parts.aus.push_back(std::move(au));
    }
  }
  return FaceModel(std::move(parts));
}

}  // namespace risorius
