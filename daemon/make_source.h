// The one place that knows which protocols there are: a [[source]] table -> its Source.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>

#include "capture/wire/source.h"
#include "daemon/config.h"

namespace risorius {

/// Binds, where the protocol listens. Throws UserError naming the address or option, and the remedy.
std::unique_ptr<Source> make_source(boost::asio::io_context& io, std::uint32_t stream_id, const SourceConfig& config,
                                    std::function<void()> on_ready);

/// Whether the source tells face shapes (SourceEventKind::kShapes) instead of markers.
bool tells_shapes(const SourceConfig& config);

}  // namespace risorius
