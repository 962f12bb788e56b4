// risorius rig show: what a rig's AUs look like, as pictures.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/face_argument.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/picture/rig_pictures.h"
#include "replay/progress_line.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

constexpr int kPictureHeight = 720;

struct ShowArguments {
  std::string rig, face, output;
};

void show(const ShowArguments& arguments) {
  const bool is_builtin = arguments.rig == "builtin";
  std::optional<FaceModel> face;
  if (!arguments.face.empty() || is_builtin) {
    face = face_of_argument(arguments.face.empty() ? "builtin" : arguments.face);
  }
  const bool is_all_builtin = is_builtin && face->name() == "builtin";
  const Rig rig = is_all_builtin ? builtin_rig_of(*face, RigColumns::kAll) : rig_of_argument(arguments.rig);
  const std::filesystem::path folder(arguments.output);
  check_not_sealed(folder);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw UserError(folder.string(), "cannot make this folder: " + error.message(), "choose another with -o");

  const RigPictures pictures(rig, face ? &*face : nullptr);
  ProgressLine progress("drawing", "pictures");
  const std::size_t sheet_cells = pictures.contact_sheet_cells(), all = 1 + rig.au_count() + sheet_cells;
  std::size_t drawn = 0;
  const auto draw = [&](const std::string& name, const std::vector<std::string>& columns) {
    pictures.picture(columns, kPictureHeight).save_png(folder / (name + ".png"));
    progress.show(++drawn, all);
  };
  draw("neutral", {});
  for (const RigAu& au : rig.aus) draw(au.name, {au.name});
  const Canvas sheet = pictures.contact_sheet([&](std::size_t done, std::size_t) { progress.show(drawn + done, all); });
  sheet.save_png(folder / "contact_sheet.png");
  progress.finish(all);
  fmt::print("written: {}, the neutral and {} AUs beside it\n", (folder / "contact_sheet.png").string(),
             rig.au_count());
}

}  // namespace

void add_rig_show_command(CLI::App& rig) {
  CLI::App* command = rig.add_subcommand("show", "draw the face at rest and each AU at its maximum, as PNG");
  auto arguments = std::make_shared<ShowArguments>();
  command->add_option("rig", arguments->rig, "a rig file, or \"builtin\"")->required();
  command->add_option("--face", arguments->face,
                      "the face that the rig was fitted from: \"builtin\", or the folder of ICT-FaceKit's OBJ files "
                      "(default: none for a rig file, which is drawn as a surface through its markers)");
  command->add_option("-o,--output", arguments->output, "folder for the pictures")->required();
  command->callback([arguments] { show(*arguments); });
}

}  // namespace risorius
