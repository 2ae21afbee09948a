// Reports sizes and offsets of the structures that host and device share, for a test.
__kernel void ccLayout(__global const CcPair* pairs, __global const CcDirection* directions,
                       __global const CcAnswer* answers, __global const CcSums* sums,
                       __global const CcContactPatch* contacts, __global uint* out) {
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
  out[12] = sizeof(CcContactPatch);
  out[13] = sizeof(CcPatchForce);
  out[14] = (uint)((__global const char*)&contacts->points[0] - (__global const char*)contacts);
  out[15] = (uint)((__global const char*)&pairs->cell - (__global const char*)pairs);
  out[16] = sizeof(CcListed);
  out[17] = sizeof(CcFacing);
  out[18] = sizeof(CcPlaced);
  out[19] = sizeof(CcShape);
  out[11] = (uint)((__global const char*)&sums->deepest - (__global const char*)sums);
}
