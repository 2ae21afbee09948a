// Macros for loops over SIMD lanes. The compiler makes a clone of such a function for each of
// several instruction sets, and the program picks the best one at its start. All clones give the
// same bits: no contraction, no reordered sums, correctly rounded division and root
// (docs/engine.md, "One arithmetic").
#pragma once

// Sanitizers instrument the resolvers that pick a clone, which run before the sanitizer is set up.
#if !defined(CLOUDCONTACT_PLAIN_LANES) && defined(__GNUC__) && !defined(__clang__) && \
    defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CC_CLONES
#define CC_LANES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CC_LANES
#endif

// Promises the compiler that the iterations of the next loop are independent, even where pointers
// might alias.
#if defined(__clang__)
#define CC_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define CC_INDEPENDENT _Pragma("GCC ivdep")
#else
#define CC_INDEPENDENT
#endif
