// A take that is a text, written as a test has it and read back.
#pragma once

#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "capture/errors.h"
#include "replay/sample_take.h"
#include "support/test_data.h"

namespace risorius::test {

class TextTake : public ::testing::Test {
 protected:
  explicit TextTake(const char* name) : path_(folder_.path() / name) {}

  std::unique_ptr<TakeReader> reader(const std::string& text, const TakeOptions& options = {}) {
    write_bytes(path_, text);
    return open_take(path_, options);
  }
  std::string error(const std::string& text) {
    return message_of<UserError>([&] { read_all(*reader(text)); });
  }

  TemporaryFolder folder_;
  std::filesystem::path path_;
};

}  // namespace risorius::test
