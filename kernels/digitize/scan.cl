// Exclusive prefix sum, computed by one group.

// Sets first[k] = sum of counts[0..k) for k from 0 to count, and counters[counter] to the total.
__kernel __attribute__((reqd_work_group_size(CC_SCAN_GROUP, 1, 1))) void ccScan(
    __global const uint* restrict counts, uint count, __global uint* restrict first, __global uint* counters,
    uint counter) {
  __local uint room[2 * CC_SCAN_GROUP];
  const uint lid = get_local_id(0), each = (count / CC_SCAN_GROUP + 4) & ~3u;
  const uint begin = min(lid * each, count), end = min(begin + each, count);
  const uint fours = begin + ((end - begin) & ~3u);
  uint4 four = (uint4)(0u);
  for (uint k = begin; k < fours; k += 4) four += vload4(0, counts + k);
  uint sum = four.x + four.y + four.z + four.w;
  for (uint k = fours; k < end; ++k) sum += counts[k];
  uint run = ccSumUpTo(room, sum) - sum;
  for (uint k = begin; k < fours; k += 4) {
    const uint4 c = vload4(0, counts + k);
    vstore4((uint4)(run, run + c.x, run + c.x + c.y, run + c.x + c.y + c.z), 0, first + k);
    run += c.x + c.y + c.z + c.w;
  }
  for (uint k = fours; k < end; ++k) {
    first[k] = run;
    run += counts[k];
  }
  if (lid == CC_SCAN_GROUP - 1) {
    first[count] = run;
    counters[counter] = run;
  }
}
