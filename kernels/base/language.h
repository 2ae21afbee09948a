// What C++ and OpenCL C spell differently: kernels compile as both.
#pragma once

#define CC_FN static inline

#if defined(__OPENCL_VERSION__)
#define CC_GLOBAL __global
// What the work-items of a group share. With private copies each work-item of the search needs 760
// bytes of stack.
#define CC_NEAR __local
#define CC_SQRT(x) sqrt(x)
#define CC_SQRT64(x) sqrt(x)
#else
#include <math.h>
#define CC_GLOBAL
#define CC_NEAR
#define CC_SQRT(x) sqrtf(x)
#define CC_SQRT64(x) sqrt(x)
typedef unsigned short ushort;
typedef unsigned int uint;
typedef unsigned long ulong;
#endif
