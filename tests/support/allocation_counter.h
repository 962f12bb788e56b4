// Counts operator new on the calling thread, so that a test can show that a stage allocates nothing.
#pragma once

#include <cstdint>

namespace risorius::test {

/// Calls of operator new by this thread since it started.
std::uint64_t allocations_of_this_thread() noexcept;

}  // namespace risorius::test
