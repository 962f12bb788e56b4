// What is fuzzed: every decoder and file reader as one function of any bytes. One table for ./run fuzz (libFuzzer,
// clang) and for fuzz_test.cpp, which runs all of them for a moment in the normal suite.
//
// An entry returns for whatever input. It may catch UserError (the declared way of refusing); anything else that is
// thrown, a broken invariant (require), a sanitizer's finding, too much time or memory is a finding. Limits: fuzz/run.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace risorius::fuzz {

using Bytes = std::vector<std::byte>;

struct Target {
  std::string_view name;
  void (*run)(std::span<const std::byte> input);
  std::vector<Bytes> (*seeds)();  ///< small valid inputs
};

std::span<const Target> targets();
/// Null if there is none of that name.
const Target* find_target(std::string_view name);

/// Ends the program if a law that must hold for any input does not.
void require(bool holds, const char* law);

// Conversations (of datagrams, or of pieces of a byte stream) are one input: records of a control byte, a u16 size, and
// so many bytes, or as many as are left.

struct Record {
  unsigned control = 0;
  Bytes bytes;  ///< a copy of exactly that size, so that the address sanitizer sees each read beyond it
};
/// False at the end.
bool take_record(std::span<const std::byte>& input, Record& record);
void append_record(unsigned control, std::span<const std::byte> bytes, Bytes& input);

std::string_view as_text(std::span<const std::byte> bytes);
Bytes bytes_of(std::string_view text);

}  // namespace risorius::fuzz
