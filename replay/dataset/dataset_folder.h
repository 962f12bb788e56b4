// A dataset: a folder with one sub-folder per take (replay/take_dataset.h), a README.md card, and manifest-sha256.txt,
// which is written last: a dataset with a manifest is complete.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace risorius {

/// Makes the folder. Throws UserError if it is there already or cannot be made.
void begin_dataset_folder(const std::filesystem::path& folder);

/// Names that no take's folder can have: those of the dataset's own files, and of these in the making.
std::set<std::string> dataset_file_names();

/// Writes README.md and then the manifest.
void finish_dataset_folder(const std::filesystem::path& folder, const std::string& card_markdown);

/// What the card says.
struct DatasetCard {
  std::string title;
  std::string rig;
  std::string mode;          ///< "live", "offline, causal" or "offline, both directions"
  std::string pseudonym;     ///< of the recorded person; empty = not stated
  std::string consent;       ///< reference to the consent; empty = not stated
  std::string licence;       ///< of the dataset; empty = not stated
  std::string options_toml;  ///< the effective options of all stages
  std::string mapped;        ///< takes whose AUs are mapped from face shapes, by source; empty = none
};
std::string dataset_card_markdown(const DatasetCard& card);

}  // namespace risorius
