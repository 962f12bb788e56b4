// A broken invariant is our mistake: stop with the expression and the place. Never for input.
#pragma once

#include <cstdio>
#include <cstdlib>

// A macro, because it prints the expression and its place.
#define RISORIUS_CHECK(expression)                                                            \
  do {                                                                                        \
    if (!(expression)) {                                                                      \
      std::fprintf(stderr, "%s:%d: broken invariant: %s\n", __FILE__, __LINE__, #expression); \
      std::abort();                                                                           \
    }                                                                                         \
  } while (false)
