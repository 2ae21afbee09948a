// The less and the more of two doubles. Plain C for C++ and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_NUMBER64_H
#define CLOUDCONTACT_KERNELS_NUMBER64_H

#ifndef CC_FN
#define CC_FN static inline
#endif

CC_FN double ccMore(double a, double b) {
  return a > b ? a : b;
}
CC_FN double ccLess(double a, double b) {
  return a < b ? a : b;
}

#endif
