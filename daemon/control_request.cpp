#include "daemon/control_request.h"

#include <nlohmann/json.hpp>

#include "capture/errors.h"

namespace risorius {

/// MessagePack from programs, JSON from people with a terminal: a JSON object begins with '{', which no MessagePack map
/// does.
nlohmann::json parse_control_request(std::span<const std::byte> message) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(message.data());
  const auto* end = begin + message.size();
  const bool is_text = !message.empty() && *begin == '{';
  const auto request = is_text ? nlohmann::json::parse(begin, end, nullptr, false)
                               : nlohmann::json::from_msgpack(begin, end, true, false);
  if (request.is_discarded()) {
    throw UserError("request",
                    message.empty() ? "is empty"
                    : is_text       ? "is broken JSON"
                                    : "is broken MessagePack",
                    "send {\"command\": \"status\"} as MessagePack or JSON");
  }
  if (!request.is_object() || !request.contains("command") || !request["command"].is_string()) {
    throw UserError("request", "is not a map with a text \"command\"",
                    "send {\"command\": \"status\"} as MessagePack or JSON");
  }
  return request;
}

}  // namespace risorius
