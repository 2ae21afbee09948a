// Measures a device: memory bandwidth, gathers, double arithmetic (plugin/device/device_probe.h).

__kernel void ccCopy(__global const float4* from, __global float4* to) {
  to[get_global_id(0)] = from[get_global_id(0)];
}

__kernel void ccGather(__global const uint2* records, uint mask, __global uint* out) {
  uint k = (uint)get_global_id(0) * 2654435761u, sum = 0;
  for (int i = 0; i < 16; ++i) {
    k = k * 1664525u + 1013904223u;
    const uint2 r = records[(k >> 7) & mask];
    sum += r.x + r.y;
  }
  out[get_global_id(0)] = sum;
}

__kernel void ccDoubles(double factor, __global double* out) {
  double a = (double)get_global_id(0), b = a + 1.0, c = a + 2.0, d = a + 3.0;
  for (int i = 0; i < 256; ++i) {
    a = a * factor + 1.0;
    b = b * factor + 1.0;
    c = c * factor + 1.0;
    d = d * factor + 1.0;
  }
  out[get_global_id(0)] = a + b + c + d;
}

__kernel void ccNothing(__global uint* out) {
  if (get_global_id(0) == 0) out[0] = 0u;
}
