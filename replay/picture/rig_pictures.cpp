#include "replay/picture/rig_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "replay/picture/marker_surface.h"
#include "solve/rigs/au_name.h"

namespace risorius {
namespace {

constexpr Colour kPaper{0.95, 0.955, 0.965, 1}, kInk{0.13, 0.14, 0.17, 1}, kGrey{0.42, 0.44, 0.48, 1},
    kMarker{1, 1, 1, 0.9}, kMarkerRim{0.10, 0.22, 0.45, 0.9}, kArrow{0.05, 0.25, 0.80, 1};
constexpr double kThreeQuarterDegrees = 38;
constexpr double kCloseUpField = 0.5;    // of the whole picture's height
constexpr double kCloseUpTowards = 0.8;  // of the way to the side that moves, so that the other one can be compared
constexpr double kLeastArrowMm = 0.7;
constexpr double kShortMm = 4, kShownMm = 6,
                 kMostScale = 8;  // arrows of AUs that move less are lengthened, and it is said
constexpr int kNoteHeight = 30;   // pixels, below the sheet

struct FacsName {
  int number;
  std::string_view name;
};
constexpr std::array kFacsNames = std::to_array<FacsName>({{1, "inner brow raiser"},
                                                           {2, "outer brow raiser"},
                                                           {4, "brow lowerer"},
                                                           {5, "upper lid raiser"},
                                                           {6, "cheek raiser"},
                                                           {7, "lid tightener"},
                                                           {9, "nose wrinkler"},
                                                           {10, "upper lip raiser"},
                                                           {11, "nasolabial deepener"},
                                                           {12, "lip corner puller"},
                                                           {13, "sharp lip puller"},
                                                           {14, "dimpler"},
                                                           {15, "lip corner depressor"},
                                                           {16, "lower lip depressor"},
                                                           {17, "chin raiser"},
                                                           {18, "lip pucker"},
                                                           {19, "tongue show"},
                                                           {20, "lip stretcher"},
                                                           {22, "lip funneler"},
                                                           {23, "lip tightener"},
                                                           {24, "lip pressor"},
                                                           {25, "lips part"},
                                                           {26, "jaw drop"},
                                                           {27, "mouth stretch"},
                                                           {28, "lip suck"},
                                                           {29, "jaw thrust"},
                                                           {30, "jaw sideways"},
                                                           {34, "puff"},
                                                           {43, "eye closure"},
                                                           {45, "blink"}});
constexpr int kJawSideways = 30;  // its sides are opposites, not halves

const RigAu& column_of(const Rig& rig, const std::string& name) {
  for (const RigAu& au : rig.aus) {
    if (au.name == name) return au;
  }
  throw std::invalid_argument("RigPictures: the rig has no column " + name);
}

/// The scale at which the face's skin meets the markers best; both have the same origin and axes.
double scale_between(const FaceModel& face, const Eigen::Matrix3Xd& markers_mm) {
  double scale = 1;
  constexpr int kSteps = 20;
  for (int step = 0; step < kSteps; ++step) {
    double marker_by_skin = 0, skin_by_skin = 0;
    for (Eigen::Index m = 0; m < markers_mm.cols(); ++m) {
      const Eigen::Vector3d skin = face.closest_skin_point(markers_mm.col(m) / scale).position_mm;
      marker_by_skin += markers_mm.col(m).dot(skin);
      skin_by_skin += skin.squaredNorm();
    }
    scale = std::clamp(marker_by_skin / skin_by_skin, 0.2, 5.0);
  }
  return scale;
}

std::string title_of(const std::vector<std::string>& columns) {
  if (columns.empty()) return "neutral";
  std::string names, description = facs_name(columns.front());
  for (const std::string& column : columns) names += (names.empty() ? "" : " + ") + column;
  if (columns.size() > 1) {
    const auto name = parse_au_name(columns.front());
    names = "AU" + std::to_string(name->number);
    description = facs_name(names);
  }
  return description.empty() ? names : names + "  " + description;
}

}  // namespace

std::string facs_name(const std::string& column) {
  const auto au = parse_au_name(column);
  if (!au) return {};
  const auto found = std::ranges::find(kFacsNames, au->number, &FacsName::number);
  if (found == kFacsNames.end()) return {};
  const std::string_view side = au->side == AuSide::kLeft ? ", left" : au->side == AuSide::kRight ? ", right" : "";
  return std::string(found->name).append(side);
}

RigPictures::RigPictures(const Rig& rig, const FaceModel* face) : rig_(rig), face_(face) {
  if (face != nullptr) {
    actor_per_face_ = scale_between(*face, rig.neutral_mm);
  } else {
    marker_triangles_ = triangulated_markers(rig.neutral_mm);
  }
  const Eigen::Vector3d low = rig.neutral_mm.rowwise().minCoeff(), high = rig.neutral_mm.rowwise().maxCoeff();
  const double height_mm = high.y() - low.y();
  camera_.target_mm = {0, 0.5 * (low.y() + high.y()) - 0.07 * height_mm, 0.28 * low.z() + 0.62 * high.z()};
  camera_.field_mm = 1.18 * std::max(height_mm, 1.1 * (high.x() - low.x()));
  camera_.distance_mm = 5 * camera_.field_mm;
}

/// The side of the face that a column moves, towards the viewer: the subject's left for "AU12L".
double RigPictures::three_quarter_degrees(const std::vector<std::string>& columns) {
  if (columns.size() != 1) return -kThreeQuarterDegrees;
  const auto name = parse_au_name(columns.front());
  return name && name->side == AuSide::kLeft ? kThreeQuarterDegrees : -kThreeQuarterDegrees;
}

MeshCamera RigPictures::close_up(const std::vector<std::string>& columns) const {
  MeshCamera camera = camera_;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0;
  const auto add = [&](const Eigen::Vector3d& at, const Eigen::Vector3d& by) {
    sum += by.squaredNorm() * at;
    weight += by.squaredNorm();
  };
  for (const std::string& column : columns) {
    const FaceAu* of_face = face_ != nullptr ? face_->find_au(column) : nullptr;
    const Eigen::Matrix3Xd& moves =
        of_face != nullptr ? of_face->displacement_mm : column_of(rig_, column).displacement_mm;
    const Eigen::Matrix3Xd& rest = of_face != nullptr ? face_->vertices_mm() : rig_.neutral_mm;
    const double scale = of_face != nullptr ? actor_per_face_ : 1;
    for (Eigen::Index v = 0; v < moves.cols(); ++v) add(scale * rest.col(v), scale * moves.col(v));
  }
  if (weight > 0) {
    camera.target_mm = {kCloseUpTowards * sum.x() / weight, sum.y() / weight, camera_.target_mm.z()};
    camera.field_mm = kCloseUpField * camera_.field_mm;
  }
  return camera;
}

void RigPictures::draw_view(Canvas& canvas, const PictureRectangle& place, const std::vector<std::string>& columns,
                            const MeshCamera& camera, double arrow_scale) const {
  MeshView view(static_cast<int>(place.width), static_cast<int>(place.height), camera);
  Eigen::Matrix3Xd moved = rig_.neutral_mm;
  for (const std::string& column : columns) moved += column_of(rig_, column).displacement_mm;
  static const Eigen::Matrix3Xd kNoColours(3, 0);
  if (face_ != nullptr) {
    Eigen::Matrix3Xd vertices = face_->vertices_mm();
    for (const std::string& column : columns) {
      if (const FaceAu* au = face_->find_au(column)) vertices += au->displacement_mm;
    }
    vertices *= actor_per_face_;
    // The lines are those of the built-in face; another face's wrinkles are not known.
    const bool has_creases = face_->name() == "builtin";
    const Eigen::Matrix3Xd rest = actor_per_face_ * face_->vertices_mm();
    const CreaseShade creases(has_creases ? columns : std::vector<std::string>{}, actor_per_face_);
    view.draw({vertices, face_->triangles(), face_->colours(), &creases, &rest, face_->skin_triangle_count()});
  } else if (marker_triangles_.cols() > 0) {
    view.draw({moved, marker_triangles_, kNoColours});
  }
  canvas.begin_clip(place);
  view.paint_on(canvas, {place.x, place.y});
  const auto on_canvas = [&](const Eigen::Vector3d& p) {
    const PicturePoint at = view.project(p);
    return PicturePoint{place.x + at.x, place.y + at.y};
  };
  const double unit = std::max(1.0, place.height / 420);
  for (Eigen::Index m = 0; m < moved.cols(); ++m) {
    constexpr double kUnderSkinMm = 9;  // a marker whose skin bulges over its rest still has an arrow
    if (!view.is_visible(moved.col(m), 3) && !view.is_visible(rig_.neutral_mm.col(m), kUnderSkinMm)) continue;
    const PicturePoint from = on_canvas(rig_.neutral_mm.col(m));
    canvas.fill_circle(from, 2.1 * unit, kMarkerRim);
    canvas.fill_circle(from, 1.3 * unit, kMarker);
    const Eigen::Vector3d way = arrow_scale * (moved.col(m) - rig_.neutral_mm.col(m));
    if (way.norm() < kLeastArrowMm) continue;
    canvas.arrow(from, on_canvas(rig_.neutral_mm.col(m) + way), kArrow, 1.5 * unit);
  }
  canvas.end_clip();
}

void RigPictures::draw_cell(Canvas& canvas, const PictureRectangle& place,
                            const std::vector<std::string>& columns) const {
  const double title = std::max(20.0, 0.055 * place.height), third = place.width / 3;
  Eigen::Matrix3Xd displacement = Eigen::Matrix3Xd::Zero(3, rig_.neutral_mm.cols());
  for (const std::string& column : columns) displacement += column_of(rig_, column).displacement_mm;
  Eigen::Index marker = 0;
  const double largest_mm = displacement.colwise().norm().maxCoeff(&marker);
  // A blink or a tightened lip moves markers less than an arrow's head is long.
  const double arrow_scale =
      largest_mm > 0 && largest_mm < kShortMm ? std::clamp(std::round(kShownMm / largest_mm), 1.0, kMostScale) : 1;
  MeshCamera turned = camera_;
  turned.turned_degrees = three_quarter_degrees(columns);
  draw_view(canvas, {place.x, place.y + title, third, place.height - title}, columns, camera_, arrow_scale);
  draw_view(canvas, {place.x + third, place.y + title, third, place.height - title}, columns, turned, arrow_scale);
  draw_view(canvas, {place.x + 2 * third, place.y + title, third, place.height - title}, columns, close_up(columns),
            arrow_scale);
  canvas.text({place.x + 0.4 * title, place.y + 0.82 * title}, title_of(columns), 0.72 * title, kInk);
  if (!columns.empty()) {
    std::string note = fmt::format("{} {:.1f} mm", rig_.marker_names[static_cast<std::size_t>(marker)], largest_mm);
    if (arrow_scale > 1) note += fmt::format(", arrows x {:.0f}", arrow_scale);
    canvas.text({place.x + place.width - 0.4 * title, place.y + 0.82 * title}, note, 0.62 * title, kGrey,
                TextAnchor::kRight);
  }
}

Canvas RigPictures::picture(const std::vector<std::string>& columns, int height) const {
  if (height < 100 || height > 4000) throw std::invalid_argument("RigPictures: 100 to 4000 pixels high");
  Canvas canvas(3 * height * 8 / 10, height, kPaper);
  draw_cell(canvas, {0, 0, static_cast<double>(canvas.width()), static_cast<double>(height)}, columns);
  return canvas;
}

std::vector<std::vector<std::string>> RigPictures::sheet_columns() const {
  std::vector<std::vector<std::string>> cells{{}};
  for (const RigAu& au : rig_.aus) {
    const auto name = parse_au_name(au.name);
    const bool has_halves = name && name->side != AuSide::kBoth && name->number != kJawSideways;
    if (has_halves && cells.back().size() == 1) {
      const auto before = parse_au_name(cells.back().front());
      if (before && before->number == name->number && before->side != AuSide::kBoth) {
        cells.back().push_back(au.name);
        continue;
      }
    }
    cells.push_back({au.name});
  }
  return cells;
}

/// What the sheet does not show, and what in it is drawn on.
std::string RigPictures::sheet_note() const {
  std::string note = "Each AU at intensity 1, left and right together: front, three-quarter view, close-up.";
  if (face_ == nullptr) return note;
  if (face_->name() == "builtin") note += " Wrinkles are shading, not geometry.";
  if (face_->find_au("AU19") == nullptr) note += " AU19 (tongue show) is left out: the tongue does not move.";
  return note;
}

Canvas RigPictures::contact_sheet(const std::function<void(std::size_t, std::size_t)>& done) const {
  constexpr int kCellWidth = 780, kCellHeight = 330, kAcross = 3;
  const auto cells = sheet_columns();
  const int rows = (static_cast<int>(cells.size()) + kAcross - 1) / kAcross;
  Canvas canvas(kAcross * kCellWidth, rows * kCellHeight + kNoteHeight, kPaper);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double column = static_cast<double>(k % kAcross), row = static_cast<double>(k / kAcross);
    draw_cell(canvas, {column * kCellWidth, row * kCellHeight, kCellWidth, kCellHeight}, cells[k]);
    if (done) done(k + 1, cells.size());
  }
  canvas.text({12, rows * kCellHeight + 0.7 * kNoteHeight}, sheet_note(), 15, kGrey);
  return canvas;
}

}  // namespace risorius
