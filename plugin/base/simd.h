// Loops over lanes are compiled for several instruction sets; the machine's best is taken as the
// program starts. All give the same bits: no contraction, no reordered sums, correctly rounded
// division and root (DESIGN.md, "One arithmetic").
#pragma once

// Sanitizers instrument the choosers of clones, which run before a sanitizer is ready.
#if !defined(CLOUDCONTACT_PLAIN_LANES) && defined(__GNUC__) && !defined(__clang__) && \
    defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CC_LANES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CC_LANES
#endif

// Lanes do not depend on each other, whatever pointers may suggest.
#if defined(__clang__)
#define CC_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define CC_INDEPENDENT _Pragma("GCC ivdep")
#else
#define CC_INDEPENDENT
#endif
