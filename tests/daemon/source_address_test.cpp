#include "daemon/source_address.h"

#include <gtest/gtest.h>

#include "capture/errors.h"

namespace risorius {
namespace {

TEST(SourceAddress, ReadsWhatItPrints) {
  for (const char* url : {"udp://127.0.0.1:7000", "udp://[::1]:0", "zmq+tcp://0.0.0.0:7010", "natnet://127.0.0.1:1510",
                          "qtm://tracker.lab:22223", "vicon://[fe80::1]:801", "livelink://0.0.0.0:0"}) {
    EXPECT_EQ(to_url(parse_source_address(url)), url);
  }
}

TEST(SourceAddress, TrackersHavePortsOfTheirOwn) {
  EXPECT_EQ(to_url(parse_source_address("natnet://motive")), "natnet://motive:1510");
  EXPECT_EQ(to_url(parse_source_address("qtm://[::1]")), "qtm://[::1]:22223");
  EXPECT_EQ(to_url(parse_source_address("livelink://127.0.0.1")), "livelink://127.0.0.1:11111");
  EXPECT_EQ(to_url(parse_source_address("vicon://shogun:8010")), "vicon://shogun:8010");
}

TEST(SourceAddress, NamesWhatIsWrong) {
  for (const char* url : {"", "tcp://a:1", "udp://", "udp://a", "udp://a:", "udp://a:65536", "udp://a:1x", "udp://::1",
                          "natnet://", "natnet://a:0", "natnet://:1510", "qtm://a b", "vicon://a/b:801", "UDP://a:1"}) {
    try {
      parse_source_address(url);
      FAIL() << url;
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find("\"" + std::string(url) + "\""), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace risorius
