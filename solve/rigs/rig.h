// A rig is one actor's face as the solver sees it: the neutral marker positions E0, one displacement field e_i per AU
// at its recorded maximum, and which markers hold the head still.  E = E0 + sum_i x_i e_i,  0 <= x_i <= upper_bound_i
// (seed 003, eq. 4.1; Choe & Ko 2001). The neutral defines the head frame: x to the subject's left, y up, z out of the
// face.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace risorius {

/// One column of the basis. Named by AU: "AU" + FACS number + optional "L" or "R" (subject's side); shapes that FACS
/// does not number keep the face model's name (such as "mouthLeft").
struct RigAu {
  std::string name;
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x M, at intensity 1
  double upper_bound = 1.2;
};

struct Rig {
  std::string name;
  std::vector<std::string> marker_names;  ///< M, unique
  Eigen::Matrix3Xd neutral_mm;            ///< 3 x M, head frame
  Eigen::VectorXd stabiliser_weight;      ///< M, >= 0; at least three > 0 and not collinear
  std::vector<RigAu> aus;                 ///< K, unique names
  std::string facs_edition = "2002";
  std::string source;                   ///< how it was made: face, take, range; free text
  std::vector<double> fit_distance_mm;  ///< M or empty: how far each neutral marker sat from the face mesh

  std::size_t marker_count() const noexcept { return marker_names.size(); }
  std::size_t au_count() const noexcept { return aus.size(); }
  std::vector<std::string> au_names() const;
};

/// What is wrong with the rig, one sentence each; empty if nothing.
std::vector<std::string> problems_of(const Rig& rig);

/// Reads "risorius-rig" JSON (solve/README.md). Throws UserError naming file, field, value and remedy.
Rig load_rig(const std::filesystem::path& path);
Rig parse_rig(std::string_view json, const std::string& place);

/// Writes so that load_rig gives equal bits back; atomically (temporary file, rename).
void save_rig(const Rig& rig, const std::filesystem::path& path);
std::string rig_to_json(const Rig& rig);

}  // namespace risorius
