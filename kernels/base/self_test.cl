// Tests what a device must compute like a CPU, to the bit: rounded division and square root, no
// contraction, subnormal numbers, doubles.
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
