#include "replay/commands/take_output.h"

#include "capture/errors.h"
#include "capture/version.h"
#include "replay/commands/output_check.h"
#include "replay/takes/c3d_writer.h"
#include "replay/takes/csv_take.h"

namespace risorius {

void check_take_output(const std::filesystem::path& path) { check_output_name(path, "a take", {".c3d", ".csv"}); }

std::unique_ptr<TakeWriter> make_take_writer(const std::filesystem::path& path, const MarkerSet& markers) {
  if (path.extension() == ".c3d") return std::make_unique<C3dWriter>(path, markers, kVersion);
  if (path.extension() == ".csv") return std::make_unique<CsvTakeWriter>(path, markers);
  throw UserError(path.string(), "a take cannot be written in this form", "end the name with .c3d or .csv");
}

}  // namespace risorius
