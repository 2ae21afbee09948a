// Sixteen floats at once, for loops in CC_LANES functions (base/simd.h).
#pragma once

#include <cstring>

namespace cloudcontact {

using Sixteen [[gnu::vector_size(64)]] = float;

[[gnu::always_inline]] inline void load(const float* column, Sixteen& to) {
  std::memcpy(&to, column, sizeof to);
}

}  // namespace cloudcontact
