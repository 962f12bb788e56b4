#include "replay/commands/pace_arguments.h"

#include <CLI/CLI.hpp>

#include "capture/errors.h"

namespace risorius {

void PaceArguments::add_to(CLI::App& command) {
  command.add_option("--speed", speed, "times the take's own pace; \"max\" = as fast as the other side takes it")
      ->capture_default_str();
  command.add_flag("--loop", loop, "begin again at the end; sequence and capture time go on counting");
}

double PaceArguments::speed_factor() const {
  if (speed == "max") return 0;
  double factor = 0;
  if (!CLI::detail::lexical_cast(speed, factor) || !(factor > 0 && factor <= 1000)) {
    throw UserError("--speed", "\"" + speed + "\" is neither \"max\" nor a number above 0 and up to 1000",
                    "1 is the take's own pace");
  }
  return factor;
}

}  // namespace risorius
