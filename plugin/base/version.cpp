// The library's own version, and the vector instructions that its loops use.
#include <cloudcontact/version.h>

#include "base/simd.h"

namespace cloudcontact {

std::string_view version() {
  return CLOUDCONTACT_VERSION;
}

std::string_view vectorInstructions() {
#if defined(CC_CLONES)
  if (__builtin_cpu_supports("x86-64-v4")) return "AVX-512";
  if (__builtin_cpu_supports("x86-64-v3")) return "AVX2";
#endif
  return "baseline";
}

}  // namespace cloudcontact
