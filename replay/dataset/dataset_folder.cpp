#include "replay/dataset/dataset_folder.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/errors.h"
#include "capture/version.h"
#include "replay/atomic_file.h"
#include "replay/dataset/manifest.h"

namespace risorius {
namespace {

constexpr const char* kCardName = "README.md";

/// A YAML text in double quotes; JSON's quoting is part of YAML's.
std::string quoted(const std::string& text) {
  return nlohmann::json(text.empty() ? "not stated" : text)
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::set<std::string> dataset_file_names() {
  std::set<std::string> names;
  for (const std::string name : {kCardName, kManifestName}) names.insert({name, name + ".partial"});
  return names;
}

void begin_dataset_folder(const std::filesystem::path& given) {
  std::error_code error;
  const auto folder = given.has_filename() ? given : given.parent_path();  // "new/" is "new"
  if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
  if (!std::filesystem::create_directory(folder, error)) {
    throw UserError(
        folder.string(), error ? "cannot make this folder: " + error.message() : "this folder is there already",
        "a dataset is never written over: give a folder that does not exist yet, on a disk that can be written");
  }
}

void finish_dataset_folder(const std::filesystem::path& folder, const std::string& card_markdown) {
  AtomicFile card(folder / kCardName);
  card.write(card_markdown);
  card.commit();
  write_manifest(folder);
}

std::string dataset_card_markdown(const DatasetCard& card) {
  const std::string mapped =
      card.mapped.empty()
          ? ""
          : "**Takes of " + card.mapped +
                " have no markers**: a face tracker's shapes (ARKit) were mapped to action units. These "
                "intensities are a proxy, not a measurement.\n\n";
  return fmt::format(
      "---\n"
      "title: {}\n"
      "license: {}\n"
      "rig: {}\n"
      "processing: {}\n"
      "pseudonym: {}\n"
      "consent: {}\n"
      "risorius: {}\n"
      "instruction_set: {}\n"
      "---\n\n"
      "# {}\n\n"
      "Facial marker takes, cleaned, with FACS action-unit intensities solved from them. One folder per take:\n\n"
      "{}"
      "| file | content |\n|---|---|\n"
      "| `cleaned.c3d` | markers in mm after repair; a point that is not known has residual -1 |\n"
      "| `au.csv` | intensity of each AU per frame, 0 to the rig's bound (1 = the rig's recorded maximum); empty = not "
      "coded |\n"
      "| `au_sd.csv` | their standard deviations |\n"
      "| `pose.csv` | head pose, world from head: mm and quaternion xyzw |\n"
      "| `quality.csv` | per frame: state of every marker and AU, residual, KKT certificate |\n"
      "| `episodes.csv` | onset, apex, offset and letter of each AU episode |\n"
      "| `rig.json` | the rig that was solved with |\n"
      "| `take.json` | origin, rate, counts, versions |\n\n"
      "Whole dataset unchanged: `sha256sum -c manifest-sha256.txt`.\n\n"
      "Effective options:\n\n```toml\n{}```\n",
      quoted(card.title), quoted(card.licence), quoted(card.rig), quoted(card.mode), quoted(card.pseudonym),
      quoted(card.consent), quoted(kVersion), quoted(kInstructionSet), card.title, mapped, card.options_toml);
}

}  // namespace risorius
