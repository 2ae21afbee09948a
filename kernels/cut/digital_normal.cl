// The digital normals of many collision areas at once, a work-group for each (digital_normal.h).

__kernel void ccDigitalNormals(int nx, int ny, int nz, __global const int* table,
                               __global const CcBlock* blocks, __global const double* terms,
                               __global const CcTouchedVoxel* voxels, __global const uint* firsts,
                               __global CcNormalSum* normals) {
  __local CcNormalSum lanes[CC_NORMAL_LANES];
  const uint area = get_group_id(0), lane = get_local_id(0);
  const CcWorkpiece w = {nx, ny, nz, table, blocks, 0};
  lanes[lane] = ccSumLane(&w, terms, voxels, firsts[area] + lane, firsts[area + 1]);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (lane != 0) return;
  CcNormalSum sum = ccNoVectors();
  for (int k = 0; k < CC_NORMAL_LANES; ++k) ccAddLane(&sum, lanes[k]);
  normals[area] = sum;
}
