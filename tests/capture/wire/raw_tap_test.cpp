#include "capture/wire/raw_tap.h"

#include <arpa/inet.h>
#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <vector>

#include "capture/wire/udp_source.h"
#include "support/loopback.h"
#include "support/native_stream.h"

namespace risorius {
namespace {

TEST(RawTap, NamesTheSender) {
  sockaddr_storage v4{}, v6{};
  auto& as_v4 = reinterpret_cast<sockaddr_in&>(v4);
  as_v4.sin_family = AF_INET;
  as_v4.sin_port = htons(7000);
  inet_pton(AF_INET, "192.168.1.2", &as_v4.sin_addr);
  auto& as_v6 = reinterpret_cast<sockaddr_in6&>(v6);
  as_v6.sin6_family = AF_INET6;
  as_v6.sin6_port = htons(7001);
  inet_pton(AF_INET6, "::1", &as_v6.sin6_addr);
  EXPECT_EQ(text_of(raw_origin_of(v4)), "192.168.1.2:7000");
  EXPECT_EQ(text_of(raw_origin_of(v6)), "[::1]:7001");
  EXPECT_EQ(text_of(raw_origin_of(sockaddr_storage{})), "");
}

struct Seen {
  std::vector<test::Bytes> datagrams;
  std::size_t refused = 0;
  std::uint32_t stream_id = 0;
  std::int64_t last_ns = 0;
  std::string from;
};

void receive(void* context, std::uint32_t stream_id, const RawMessage& message) noexcept {
  auto& seen = *static_cast<Seen*>(context);
  seen.datagrams.emplace_back(message.bytes.begin(), message.bytes.end());
  seen.refused += message.is_refused ? 1 : 0;
  seen.stream_id = stream_id;
  seen.last_ns = message.receive_time_ns;
  seen.from = text_of(message.origin);
}

TEST(RawTap, HearsEveryDatagramOfASourceAsItCameAndWhichOnesWereRefused) {
  boost::asio::io_context io;
  UdpSource source(io, {.port = 0}, [&source] {
    for (SourceEvent event; source.pop(event);) {
    }
  });
  Seen seen;
  source.tap_raw({&receive, &seen, 5});
  source.start();
  test::LoopbackUdp udp(source.port());
  std::vector<test::Bytes> sent = test::datagrams_of(test::marker_set(10));
  sent.push_back(test::datagrams_of(test::marker_frame(1, 10)).at(0));
  sent.push_back({std::byte{1}, std::byte{2}, std::byte{3}});  // garbage
  for (const auto& datagram : sent) ASSERT_TRUE(udp.send(datagram));
  ASSERT_TRUE(test::run_until(io, [&] { return source.counters().datagrams.received.value() >= sent.size(); }));
  EXPECT_EQ(seen.datagrams, sent);
  EXPECT_EQ(seen.refused, 1u);
  EXPECT_EQ(seen.stream_id, 5u);
  EXPECT_GT(seen.last_ns, 0);
  EXPECT_TRUE(seen.from.starts_with("127.0.0.1:")) << seen.from;
}

}  // namespace
}  // namespace risorius
