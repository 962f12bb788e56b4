#include "capture/wire/source.h"

namespace risorius {

std::string_view name_of(LinkState state) noexcept {
  switch (state) {
    case LinkState::kListening:
      return "listening";
    case LinkState::kConnecting:
      return "connecting";
    case LinkState::kWaiting:
      return "waiting";
    case LinkState::kStreaming:
      return "streaming";
    case LinkState::kLost:
      return "lost";
  }
  return "unknown";
}

}  // namespace risorius
