#include "daemon/status.h"

#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "daemon/service.h"
#include "support/test_data.h"

namespace risorius {
namespace {

Config on_free_ports() {
  Config config = default_config();
  config.sources[0].listen = "udp://127.0.0.1:0";
  config.output.publish = config.output.control = "tcp://127.0.0.1:*";
  return config;
}

TEST(Status, EveryCounterStandsInTheReadme) {
  std::ifstream file(std::filesystem::path(RISORIUS_SOURCE_DIR) / "daemon/README.md");
  std::ostringstream text;
  text << file.rdbuf();
  const std::string readme = text.str();
  const Service service(on_free_ports());
  const auto face = service.status().at("streams").at("face");
  for (const auto& [name, value] : face.items()) {
    if (name == "endpoint" || name == "rig") continue;
    EXPECT_NE(readme.find("`" + name), std::string::npos) << name << " is not explained";
    if (!value.is_object() || value.contains("received")) continue;
    for (const auto& [inner, ignored] : value.items())
      EXPECT_NE(readme.find(inner), std::string::npos) << name << "." << inner;
  }
}

TEST(Status, SummaryOfAFreshServiceIsReadable) {
  const Service service(on_free_ports());
  const std::string summary = summary_of(service.status());
  for (const char* word : {"face", "datagrams", "received 0", "lost 0", "published 0 messages"}) {
    EXPECT_NE(summary.find(word), std::string::npos) << word << " in\n" << summary;
  }
}

}  // namespace
}  // namespace risorius
