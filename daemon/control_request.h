// The bytes of a control message -> its map. Any bytes give a request or an exception.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>

namespace risorius {

/// A request is short; and the MessagePack reader recurses, so that the size also bounds its depth.
inline constexpr std::size_t kMostRequestBytes = 4096;

/// A MessagePack or JSON map with a text "command". Throws UserError, or the parser's own nlohmann::json::exception.
nlohmann::json parse_control_request(std::span<const std::byte> message);

}  // namespace risorius
