// Pictures of a rig: the face (or, without one, a surface through the markers) from the front, in three-quarter view
// (from the side that moves) and close up, at rest and with each AU at intensity 1, arrows from each marker's rest to
// where the AU takes it; and a contact sheet of all AUs, sides together. Wrinkles are shading (facial_creases.h).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "replay/picture/canvas.h"
#include "replay/picture/mesh_view.h"
#include "solve/faces/face_model.h"
#include "solve/rigs/rig.h"

namespace risorius {

class RigPictures {
 public:
  /// `face` may be null; it and `rig` must outlive the pictures. A face is scaled to the rig's markers.
  RigPictures(const Rig& rig, const FaceModel* face);

  /// The three views with the columns of these names at 1 (none: the neutral), titled; `height` pixels high, 100 to
  /// 4000. Throws std::invalid_argument for a column that the rig does not have.
  Canvas picture(const std::vector<std::string>& columns, int height) const;
  /// The neutral and each AU, left and right together, in a grid. `done` is called after each.
  Canvas contact_sheet(const std::function<void(std::size_t done, std::size_t of)>& done = {}) const;
  std::size_t contact_sheet_cells() const { return sheet_columns().size(); }

 private:
  std::vector<std::vector<std::string>> sheet_columns() const;
  static double three_quarter_degrees(const std::vector<std::string>& columns);
  /// From the front, at what moves.
  MeshCamera close_up(const std::vector<std::string>& columns) const;
  std::string sheet_note() const;
  void draw_view(Canvas& canvas, const PictureRectangle& place, const std::vector<std::string>& columns,
                 const MeshCamera& camera, double arrow_scale) const;
  void draw_cell(Canvas& canvas, const PictureRectangle& place, const std::vector<std::string>& columns) const;

  const Rig& rig_;
  const FaceModel* face_;
  double actor_per_face_ = 1;
  Eigen::Matrix3Xi marker_triangles_;
  MeshCamera camera_;
};

/// "AU12L" -> "lip corner puller, left" (FACS 2002); empty for names that are no AU.
std::string facs_name(const std::string& column);

}  // namespace risorius
