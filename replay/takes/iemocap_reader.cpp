#include "replay/takes/iemocap_reader.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "capture/errors.h"

namespace risorius {
namespace {

constexpr std::array<std::string_view, 55> kFaceMarkers{
    "CH1",   "CH2",  "CH3",  "FH1",   "FH2",    "FH3",   "LC1",    "LC2",   "LC3",   "LC4",   "LC5",
    "LC6",   "LC7",  "LC8",  "RC1",   "RC2",    "RC3",   "RC4",    "RC5",   "RC6",   "RC7",   "RC8",
    "LLID",  "RLID", "MH",   "MNOSE", "LNSTRL", "TNOSE", "RNSTRL", "LBM0",  "LBM1",  "LBM2",  "LBM3",
    "RBM0",  "RBM1", "RBM2", "RBM3",  "LBRO1",  "LBRO2", "LBRO3",  "LBRO4", "RBRO1", "RBRO2", "RBRO3",
    "RBRO4", "Mou1", "Mou2", "Mou3",  "Mou4",   "Mou5",  "Mou6",   "Mou7",  "Mou8",  "LHD",   "RHD"};

bool is_title(std::string_view cell) { return cell == "Frame#" || cell == "Time"; }

}  // namespace

IemocapReader::IemocapReader(const std::filesystem::path& path, const TakeOptions& options)
    : RowTakeReader(path, Cells::kBlanks) {
  if (!next_line()) throw UserError(path.string(), "the file is empty", "its first line must name the markers");
  std::vector<std::string> names;
  for (const std::string_view cell : cells()) {
    // A name may stand once, or above each of its three coordinates.
    if (!is_title(cell) && (names.empty() || names.back() != cell)) names.emplace_back(cell);
  }
  if (!next_line() || cells().size() < 2 || cells()[0] != "Frame#") {
    throw UserError(
        place(), "the second line does not begin with Frame# Time",
        "a .txt is a MOCAP file of IEMOCAP, or a Kinect's points, whose first line begins with 0.0 0x 0y 0z");
  }
  if (cells().size() != 2 + 3 * names.size()) {
    throw UserError(place(), fmt::format("{} columns for {} marker names", cells().size(), names.size()),
                    "each marker needs x, y and z");
  }
  std::vector<std::size_t> first_cells;
  std::vector<std::string> left_out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(kFaceMarkers, names[i]) == kFaceMarkers.end()) {
      left_out.push_back(names[i]);
      continue;
    }
    first_cells.push_back(2 + 3 * i);
    info_.markers.names.push_back(names[i]);
  }
  if (first_cells.empty()) {
    throw UserError(path.string(), fmt::format("none of its {} markers is one of IEMOCAP's face markers", names.size()),
                    "check that this is a MOCAP file of IEMOCAP");
  }
  if (!left_out.empty()) {
    info_.warnings.push_back(fmt::format("not of the face, left out: {}", fmt::join(left_out, ", ")));
  }
  begin_rows({std::move(first_cells), 2 + 3 * names.size(), false, 0}, options);
}

}  // namespace risorius
