#include "replay/live/send_target.h"

#include <gtest/gtest.h>
#include <string>

#include "capture/errors.h"

namespace risorius {
namespace {

TEST(SendTarget, ReadsWhatItWrites) {
  for (const char* url :
       {"udp://127.0.0.1:7000", "zmq+tcp://stage-pc.local:1", "udp://[::1]:65535", "zmq+tcp://[fe80::1%eth0]:7001"}) {
    EXPECT_EQ(to_url(parse_send_target(url)), url);
  }
  const SendTarget target = parse_send_target("zmq+tcp://[::1]:7001");
  EXPECT_EQ(target.transport, Transport::kZmqPush);
  EXPECT_EQ(target.host, "::1");
  EXPECT_EQ(target.port, 7001);
}

TEST(SendTarget, QuotesWhatItCannotRead) {
  for (const std::string url : {"", "7000", "127.0.0.1:7000", "tcp://a:1", "udp:/a:1", "udp://", "udp://a",
                                "udp://a:", "udp://:7000", "udp://a:0", "udp://a:65536", "udp://a:-1", "udp://a:70x",
                                "udp://a:7000/", "udp://::1:7000", "udp://[::1]", "udp://a b:7000", "UDP://a:7000"}) {
    try {
      parse_send_target(url);
      ADD_FAILURE() << url << " was read";
    } catch (const UserError& error) {
      EXPECT_EQ(std::string(error.what()).find('"' + url + '"'), 0u) << error.what();
      EXPECT_NE(std::string(error.what()).find("udp://HOST:PORT"), std::string::npos) << error.what();
    }
  }
}

TEST(SendTarget, CapsOnlyTheTransportThatDoesNotSlowSendersDown) {
  EXPECT_GT(default_frame_cap_hz(Transport::kUdp), 1000);  // the fastest rate that live sessions have
  EXPECT_EQ(default_frame_cap_hz(Transport::kZmqPush), 0);
}

}  // namespace
}  // namespace risorius
