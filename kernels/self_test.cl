// What a device must do like a CPU, to the bit: rounded division and root, no contraction, numbers
// below the normal ones, doubles.
__kernel void ccSelfTest(__global const float* a, __global const float* b, __global const float* c,
                         __global float* out, __global double* wide) {
  const size_t i = get_global_id(0), n = get_global_size(0);
  const float x = a[i], y = b[i], z = c[i];
  out[i] = x / y;
  out[n + i] = sqrt(x);
  out[2 * n + i] = x * y + z;
  out[3 * n + i] = 1.0f / sqrt(ccMax(x * x - y * y, z * z));
  const double p = x, q = y, r = z;
  wide[i] = p / q;
  wide[n + i] = sqrt(p);
  wide[2 * n + i] = (p / 3.0) * (q / 7.0) + r / 11.0;
}

// Sizes and places in the structures that host and device share.
__kernel void ccLayout(__global const CcPair* pairs, __global const CcDirection* directions,
                       __global const CcAnswer* answers, __global const CcSums* sums,
                       __global uint* out) {
  out[0] = sizeof(CcField);
  out[1] = sizeof(CcDirection);
  out[2] = sizeof(CcPair);
  out[3] = sizeof(CcFound);
  out[4] = sizeof(CcAnswer);
  out[5] = sizeof(CcBin);
  out[6] = sizeof(CcSums);
  out[7] = sizeof(CcSprout);
  out[8] = (uint)((__global const char*)&pairs->enough[0] - (__global const char*)pairs);
  out[9] = (uint)((__global const char*)&directions->nearby[0] - (__global const char*)directions);
  out[10] = (uint)((__global const char*)&answers->firstPatch - (__global const char*)answers);
  out[11] = (uint)((__global const char*)&sums->deepest - (__global const char*)sums);
}
