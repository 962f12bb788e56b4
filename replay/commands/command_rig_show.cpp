// risorius rig show: what a rig's AUs look like, as pictures.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "capture/errors.h"
#include "replay/commands/commands.h"
#include "replay/commands/face_argument.h"
#include "replay/commands/output_check.h"
#include "replay/commands/rig_argument.h"
#include "replay/picture/rig_pictures.h"
#include "replay/progress_line.h"
#include "replay/unfinished_paths.h"
#include "solve/faces/builtin_face.h"

namespace risorius {
namespace {

constexpr int kPictureHeight = 720;

struct ShowArguments {
  std::string rig, face, output;
};

/// The neutral and each AU, on all cores. `done` is called with how many are ready, from one thread at a time.
void draw_in_parallel(const RigPictures& pictures, const Rig& rig, const std::filesystem::path& folder,
                      const std::function<void(std::size_t)>& done) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t ready = 0;
  std::exception_ptr error;
  const auto work = [&] {
    for (std::size_t i = next++; i <= rig.au_count(); i = next++) {
      try {
        const std::vector<std::string> columns = i == 0 ? std::vector<std::string>{} : std::vector{rig.aus[i - 1].name};
        const std::string name = i == 0 ? "neutral" : columns.front();
        pictures.picture(columns, kPictureHeight).save_png(folder / (name + ".png"));
        const std::scoped_lock lock(mutex);
        done(++ready);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!error) error = std::current_exception();
        next = rig.au_count() + 1;
      }
    }
  };
  {
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) workers.emplace_back(work);
  }
  if (error) std::rethrow_exception(error);
}

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

  const UnfinishedPath unfinished(folder);  // a folder without a picture goes with Ctrl-C
  const RigPictures pictures(rig, face ? &*face : nullptr);
  ProgressLine progress("drawing", "pictures");
  const std::size_t sheet_cells = pictures.contact_sheet_cells(), all = 1 + rig.au_count() + sheet_cells;
  std::size_t drawn = 0;
  draw_in_parallel(pictures, rig, folder, [&](std::size_t done) { progress.show(drawn = done, all); });
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
