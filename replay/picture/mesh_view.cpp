#include "replay/picture/mesh_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace risorius {
namespace {

constexpr double kFaceBeginsZMm = 30;   // behind it the frontal plane says nothing
constexpr double kCreaseShadow = 0.28;  // of the light, per mm of depth
constexpr int kSamples = 2;             // per pixel and axis
constexpr double kDegree = 3.14159265358979323846 / 180;
const Eigen::Vector3d kSkin{0.80, 0.62, 0.53};

double to_linear(double srgb) noexcept { return std::pow(std::clamp(srgb, 0.0, 1.0), 2.2); }
double to_srgb(double linear) noexcept { return std::pow(std::clamp(linear, 0.0, 1.0), 1 / 2.2); }
/// std::pow takes a third of the time of a picture.
double to_the_18th(double x) noexcept {
  const double x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
  return x8 * x8 * x2;
}

/// Area-weighted normals of the vertices, unit length.
Eigen::Matrix3Xd normals_of(const ShadedMesh& mesh) {
  Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, mesh.vertices_mm.cols());
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
    const Eigen::Vector3i v = mesh.triangles.col(t);
    const Eigen::Vector3d a = mesh.vertices_mm.col(v[0]);
    const Eigen::Vector3d normal =
        (mesh.vertices_mm.col(v[1]) - a).cross(Eigen::Vector3d(mesh.vertices_mm.col(v[2]) - a));
    for (const int corner : v) normals.col(corner) += normal;
  }
  for (Eigen::Index v = 0; v < normals.cols(); ++v) {
    const double length = normals.col(v).norm();
    normals.col(v) = length > 0 ? Eigen::Vector3d(normals.col(v) / length) : Eigen::Vector3d::UnitZ();
  }
  return normals;
}

/// How much light reaches a vertex: less where its neighbours stand before it (a fold), a little more on ridges. The
/// bend is averaged over the neighbours twice, so that single vertices do not spot the skin.
Eigen::VectorXd openness_of(const ShadedMesh& mesh, const Eigen::Matrix3Xd& normals) {
  const Eigen::Index count = mesh.vertices_mm.cols();
  Eigen::VectorXd bend = Eigen::VectorXd::Zero(count), weight = Eigen::VectorXd::Constant(count, 1e-9);
  const auto for_edges = [&](const auto& visit) {
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles(k, t), b = mesh.triangles((k + 1) % 3, t);
        visit(a, b);
        visit(b, a);
      }
    }
  };
  for_edges([&](int a, int b) {
    const Eigen::Vector3d edge = mesh.vertices_mm.col(b) - mesh.vertices_mm.col(a);
    const double length = edge.norm();
    if (length <= 0) return;
    bend[a] += edge.dot(normals.col(a)) / length * std::min(length, 3.0);
    weight[a] += std::min(length, 3.0);
  });
  bend = bend.cwiseQuotient(weight);
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::VectorXd sum = bend, seen = Eigen::VectorXd::Ones(count);
    for_edges([&](int a, int b) {
      sum[a] += 0.5 * bend[b];
      seen[a] += 0.5;
    });
    bend = sum.cwiseQuotient(seen);
  }
  return (1 - 1.9 * bend.array()).cwiseMax(0.35).cwiseMin(1.12).matrix();
}

/// Key light from above and the viewer's left, a weak fill from the right, a little from all around.
Eigen::Vector3d lit(const Eigen::Vector3d& colour, const Eigen::Vector3d& normal, double openness) noexcept {
  static const Eigen::Vector3d key = Eigen::Vector3d(-0.55, 0.62, 0.75).normalized();
  static const Eigen::Vector3d fill = Eigen::Vector3d(0.8, 0.1, 0.55).normalized();
  static const Eigen::Vector3d half = (key + Eigen::Vector3d::UnitZ()).normalized();
  // Light creeps around the skin's edges: red more than blue.
  const double facing = normal.dot(key);
  const auto wrapped = [&](double wrap) { return std::max(0.0, (facing + wrap) / (1 + wrap)); };
  const Eigen::Vector3d diffuse(wrapped(0.32), wrapped(0.22), wrapped(0.18));
  const double fill_light = 0.30 * std::max(0.0, normal.dot(fill)), around = 0.17 + 0.07 * normal.y();
  const double gloss = 0.055 * to_the_18th(std::max(0.0, normal.dot(half)));
  return openness * (colour.cwiseProduct(0.92 * diffuse + Eigen::Vector3d::Constant(fill_light + around)) +
                     Eigen::Vector3d::Constant(gloss));
}

}  // namespace

MeshView::MeshView(int width, int height, const MeshCamera& camera)
    : width_(width), height_(height), camera_(camera), samples_per_mm_(kSamples * height / camera.field_mm) {
  if (width < 1 || height < 1 || width > 8192 || height > 8192) {
    throw std::invalid_argument("MeshView: a picture has 1 to 8192 pixels each way");
  }
  if (!(camera.distance_mm > 0) || !(camera.field_mm > 0)) {
    throw std::invalid_argument("MeshView: the camera's distance and field must be above 0 mm");
  }
  view_from_head_ = Eigen::AngleAxisd(-camera.turned_degrees * kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const auto samples = static_cast<std::size_t>(width * kSamples) * static_cast<std::size_t>(height * kSamples);
  nearness_.assign(samples, 0);
  light_.assign(samples, Eigen::Vector3f::Zero());
}

Eigen::Vector3d MeshView::view_of(const Eigen::Vector3d& point_mm) const noexcept {
  return view_from_head_ * (point_mm - camera_.target_mm);
}

Eigen::Vector2d MeshView::sample_of(const Eigen::Vector3d& view_mm) const noexcept {
  const double scale = samples_per_mm_ * camera_.distance_mm / std::max(1.0, camera_.distance_mm - view_mm.z());
  // The viewer faces the subject: the subject's left is at the picture's right.
  return {0.5 * kSamples * width_ + scale * view_mm.x(), 0.5 * kSamples * height_ - scale * view_mm.y()};
}

PicturePoint MeshView::project(const Eigen::Vector3d& point_mm) const noexcept {
  const Eigen::Vector2d sample = sample_of(view_of(point_mm));
  return {sample.x() / kSamples, sample.y() / kSamples};
}

bool MeshView::is_visible(const Eigen::Vector3d& point_mm, double tolerance_mm) const noexcept {
  const Eigen::Vector3d view = view_of(point_mm);
  const Eigen::Vector2d sample = sample_of(view);
  const auto x = static_cast<int>(std::floor(sample.x())), y = static_cast<int>(std::floor(sample.y()));
  if (x < 0 || y < 0 || x >= width_ * kSamples || y >= height_ * kSamples) return false;
  const double near = nearness_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ * kSamples) +
                                static_cast<std::size_t>(x)];
  return near <= 0 || camera_.distance_mm - view.z() <= 1 / near + tolerance_mm;
}

void MeshView::draw(const ShadedMesh& mesh) {
  const Eigen::Matrix3Xd normals = normals_of(mesh);
  const Eigen::VectorXd openness = openness_of(mesh, normals);
  std::vector<Corner> corners(static_cast<std::size_t>(mesh.vertices_mm.cols()));
  for (Eigen::Index v = 0; v < mesh.vertices_mm.cols(); ++v) {
    const Eigen::Vector3d srgb = mesh.colours.cols() == 0 ? kSkin : Eigen::Vector3d(mesh.colours.col(v));
    corners[static_cast<std::size_t>(v)] = {
        view_of(mesh.vertices_mm.col(v)), view_from_head_ * normals.col(v), srgb.unaryExpr(&to_linear),
        mesh.rest_mm ? Eigen::Vector3d(mesh.rest_mm->col(v)) : Eigen::Vector3d::Zero(), openness[v]};
  }
  const CreaseShade* creases = mesh.rest_mm && mesh.creases && !mesh.creases->empty() ? mesh.creases : nullptr;
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
    const Eigen::Vector3i v = mesh.triangles.col(t);
    draw_triangle(corners[static_cast<std::size_t>(v[0])], corners[static_cast<std::size_t>(v[1])],
                  corners[static_cast<std::size_t>(v[2])], t < mesh.creased_triangles ? creases : nullptr);
  }
}

Eigen::Vector3f MeshView::light_of(const Corner& at, const CreaseShade* creases) const {
  if (creases == nullptr || at.rest_mm.z() < kFaceBeginsZMm) return lit(at.colour, at.normal, at.shade).cast<float>();
  constexpr double kStepMm = 0.2;
  const double x = at.rest_mm.x(), y = at.rest_mm.y(), height = creases->height_mm(x, y);
  const Eigen::Vector3d slope((creases->height_mm(x + kStepMm, y) - height) / kStepMm,
                              (creases->height_mm(x, y + kStepMm) - height) / kStepMm, 0);
  // The smooth skin leans over by the fold's slope, and little light reaches the bottom.
  const Eigen::Vector3d tilt = view_from_head_ * slope;
  const Eigen::Vector3d normal = (at.normal - (tilt - at.normal.dot(tilt) * at.normal)).normalized();
  return lit(at.colour, normal, at.shade * std::clamp(1 + kCreaseShadow * height, 0.5, 1.08)).cast<float>();
}

void MeshView::draw_triangle(const Corner& a, const Corner& b, const Corner& c, const CreaseShade* creases) {
  const std::array<const Corner*, 3> corner{&a, &b, &c};
  std::array<Eigen::Vector2d, 3> at;
  std::array<double, 3> near{};
  for (std::size_t k = 0; k < 3; ++k) {
    at[k] = sample_of(corner[k]->view_mm);
    near[k] = 1 / std::max(1.0, camera_.distance_mm - corner[k]->view_mm.z());
  }
  const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); };
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  if (!(area < 0)) return;  // seen from behind: counter-clockwise is negative where y runs downwards
  const int columns = width_ * kSamples, rows = height_ * kSamples;
  const auto low = [&](int axis) { return std::min({at[0][axis], at[1][axis], at[2][axis]}); };
  const auto high = [&](int axis) { return std::max({at[0][axis], at[1][axis], at[2][axis]}); };
  const int x0 = std::max(0, static_cast<int>(std::floor(low(0)))),
            x1 = std::min(columns - 1, static_cast<int>(high(0)));
  const int y0 = std::max(0, static_cast<int>(std::floor(low(1)))), y1 = std::min(rows - 1, static_cast<int>(high(1)));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      const double w0 = cross(at[1] - p, at[2] - p) / area, w1 = cross(at[2] - p, at[0] - p) / area, w2 = 1 - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const double nearness = w0 * near[0] + w1 * near[1] + w2 * near[2];
      const std::size_t sample =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
      if (nearness <= nearness_[sample]) continue;
      nearness_[sample] = static_cast<float>(nearness);
      const Eigen::Vector3d normal = (w0 * a.normal + w1 * b.normal + w2 * c.normal).normalized();
      light_[sample] = light_of({{},
                                 normal,
                                 w0 * a.colour + w1 * b.colour + w2 * c.colour,
                                 w0 * a.rest_mm + w1 * b.rest_mm + w2 * c.rest_mm,
                                 w0 * a.shade + w1 * b.shade + w2 * c.shade},
                                creases);
    }
  }
}

void MeshView::paint_on(Canvas& canvas, PicturePoint at) const {
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const auto columns = static_cast<std::size_t>(width_ * kSamples);
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double covered = 0;
      for (std::size_t j = 0; j < kSamples; ++j) {
        for (std::size_t i = 0; i < kSamples; ++i) {
          const std::size_t sample = (y * kSamples + j) * columns + x * kSamples + i;
          if (nearness_[sample] <= 0) continue;
          sum += light_[sample].cast<double>();
          covered += 1;
        }
      }
      if (covered == 0) continue;
      const double alpha = covered / (kSamples * kSamples);
      const Eigen::Vector3d srgb = alpha * (sum / covered).unaryExpr(&to_srgb);
      const auto byte = [](double value) { return static_cast<std::uint32_t>(std::lround(255 * value)); };
      pixels[y * static_cast<std::size_t>(width_) + x] =
          byte(alpha) << 24 | byte(srgb[0]) << 16 | byte(srgb[1]) << 8 | byte(srgb[2]);
    }
  }
  canvas.image(at, pixels, width_);
}

}  // namespace risorius
