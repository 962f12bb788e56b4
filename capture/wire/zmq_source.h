// Receives the native protocol over ZeroMQ: messages of one socket -> events of one MarkerStreamDecoder.
// Lives on the thread that runs the io_context, woken through ZMQ_FD. Takes a bounded number of messages and then calls
// `on_ready` once, which should pop the decoder until it has no more. If it leaves the decoder full, the source pauses
// until resume(); with PUSH and PULL the sender is held up then, and nothing is lost.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "capture/wire/curve_keys.h"
#include "capture/wire/marker_stream_decoder.h"
#include "capture/wire/source.h"

namespace boost::asio {
class io_context;
}

namespace risorius {

/// kPull: senders PUSH and are held up when we are slow. kSubscribe: senders PUB and throw away what is too much.
enum class ZmqPattern : std::uint8_t { kPull, kSubscribe };

struct ZmqSourceOptions {
  std::string endpoint = "tcp://127.0.0.1:7001";  ///< "tcp://127.0.0.1:*": the system chooses the port
  ZmqPattern pattern = ZmqPattern::kPull;
  bool connect = false;        ///< instead of bind
  int high_water_mark = 1000;  ///< messages that ZeroMQ may hold for us per sender, 1 to 1000000
  CurveServer curve;           ///< without keys: anybody may send, and it can be read on the way
  DecoderOptions decoder;
};

class ZmqSource : public Source {
 public:
  /// Binds or connects. Throws UserError naming the endpoint or option, and the remedy.
  ZmqSource(boost::asio::io_context& io, const ZmqSourceOptions& options, std::function<void()> on_ready);
  ~ZmqSource() override;

  void tap_raw(const RawTap& tap) noexcept override;
  void start() override;
  void stop() noexcept override;
  void resume() override;
  bool pop(SourceEvent& event) noexcept override;
  void flush() noexcept override;
  std::string endpoint() const override;
  const SourceCounters& counters() const noexcept override;

  MarkerStreamDecoder& decoder() noexcept;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handler that waits in the io_context
};

}  // namespace risorius
