// The Live Link Face app for tests: sends a recording of the app to one address, frame after frame (UDP). It has no
// clients that connect: everything goes to the target. Packets hold the recording's shapes as floats, in the order of
// the packets whatever order the file has; head and eye rotations are 0, because the recording's reader leaves them
// out.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <string>
#include <vector>

#include "capture/wire/live_link_codec.h"
#include "replay/live/tracker_server.h"
#include "replay/takes/live_link_csv.h"
#include "replay/takes/take.h"

namespace risorius {

struct LiveLinkSenderOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 11111;
  std::string device = "Risorius";
  LiveLinkVersionForm form = LiveLinkVersionForm::kU32;
  std::int32_t first_frame = 0;  ///< frames since midnight of the recording's first frame
};

/// The timing of a recording: frames without markers, numbered as the recording's are, for a TakePlayer.
class LiveLinkTiming : public TakeReader {
 public:
  LiveLinkTiming(const std::filesystem::path& path, const LiveLinkTake& take);
  const TakeInfo& info() const noexcept override { return info_; }
  bool next(MarkerFrame& frame) override;
  void rewind() override { next_ = 0; }

 private:
  TakeInfo info_;
  const LiveLinkTake& take_;
  std::size_t next_ = 0;
};

class LiveLinkSender : public TrackerServer {
 public:
  /// `take` outlives the sender. Throws UserError naming the address, or the shape that the recording lacks.
  LiveLinkSender(boost::asio::io_context& io, const LiveLinkTake& take, const LiveLinkSenderOptions& options);

  void start(const MarkerSet& set) override;
  /// The shapes of the frame with this sequence; a sequence beyond the recording's end is of a later round. A frame
  /// without any shape goes out as one without a face.
  void send_frame(const MarkerFrame& frame, std::int64_t exposure_ns) override;
  void stop() noexcept override;
  std::size_t streaming_clients() const noexcept override { return 1; }
  std::string endpoint() const override;
  const TrackerServerStatistics& statistics() const noexcept override { return statistics_; }

 private:
  const LiveLinkTake& take_;
  LiveLinkSenderOptions options_;
  boost::asio::ip::udp::socket socket_;
  boost::asio::ip::udp::endpoint target_;
  std::vector<std::size_t> column_of_shape_;
  LiveLinkPacket packet_;
  ByteAppender bytes_;
  TrackerServerStatistics statistics_;
};

}  // namespace risorius
