// Receives a protocol of datagrams: those of one socket -> events of one decoder, MarkerStreamDecoder (the native
// protocol) or LiveLinkSession.
// Lives on the thread that runs the io_context. Drains the socket in bounded batches and then calls `on_ready` once,
// which should pop the events until it has no more. If it leaves the decoder full, the source pauses until resume():
// what comes meanwhile waits in the kernel's buffer, and what does not fit there is counted as kernel_drops. Nothing
// allocates per frame.
//
// Fairness: all sources share the thread. A source whose full turns bring nothing but refused and repeated datagrams (a
// flood of garbage) rests after each for twice as long as before, up to FloodRest::kLongest; what its buffer cannot
// hold meanwhile is counted as kernel_drops. One datagram of use ends that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "capture/wire/live_link_session.h"
#include "capture/wire/marker_stream_decoder.h"
#include "capture/wire/source.h"

namespace boost::asio {
class io_context;
}

namespace risorius {

template <class Options>
struct UdpSourceOptionsOf {
  std::string address = "127.0.0.1";                   ///< of the interface to listen on, IPv4 or IPv6
  std::uint16_t port = 7000;                           ///< 0: the system chooses
  std::size_t receive_buffer_bytes = 8 * 1024 * 1024;  ///< asked of the kernel, 1 KiB to 1 GiB
  Options decoder;
};

/// `Decoder`: MarkerStreamDecoder or LiveLinkSession, made of its `Options`.
template <class Decoder, class Options>
class UdpSourceOf : public Source {
 public:
  /// Binds. Throws UserError naming address:port or the option, and the remedy.
  UdpSourceOf(boost::asio::io_context& io, const UdpSourceOptionsOf<Options>& options, std::function<void()> on_ready);
  ~UdpSourceOf() override;

  void tap_raw(const RawTap& tap) noexcept override;
  void start() override;
  void stop() noexcept override;
  void resume() override;
  bool pop(SourceEvent& event) noexcept override;
  void flush() noexcept override;
  std::string endpoint() const override;
  const SourceCounters& counters() const noexcept override;

  Decoder& decoder() noexcept;
  std::uint16_t port() const noexcept;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  ///< shared with the handler that waits in the io_context
};

using UdpSourceOptions = UdpSourceOptionsOf<DecoderOptions>;
using UdpSource = UdpSourceOf<MarkerStreamDecoder, DecoderOptions>;
using LiveLinkSourceOptions = UdpSourceOptionsOf<LiveLinkOptions>;
using LiveLinkSource = UdpSourceOf<LiveLinkSession, LiveLinkOptions>;
extern template class UdpSourceOf<MarkerStreamDecoder, DecoderOptions>;
extern template class UdpSourceOf<LiveLinkSession, LiveLinkOptions>;

}  // namespace risorius
