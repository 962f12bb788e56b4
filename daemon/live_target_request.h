// The control message `go_to` -> what it asks for.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "generate/shown_face.h"

namespace risorius {

struct LiveTargetRequest {
  std::string stream;  ///< empty: the only one
  LiveTarget target;
  /// "seconds" was "auto": as long as the model says that a face takes, not target.seconds; and back likewise, if
  /// return_seconds was not given.
  bool is_seconds_auto = false, is_return_auto = false;
  std::vector<std::string> masked;  ///< AUs of the expression that the stream does not have
};

/// `au_names` of the stream. Throws UserError: keys that are not known, no target or two, an AU that the stream does
/// not have, numbers out of range.
LiveTargetRequest live_target_of(const nlohmann::json& request, const std::vector<std::string>& au_names);

}  // namespace risorius
