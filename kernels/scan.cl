// Sums over all before, by one group.

// first[k] = sum of counts[0..k), for k from 0 to count; the last is also counters[counter].
__kernel __attribute__((reqd_work_group_size(CC_SCAN_GROUP, 1, 1))) void ccScan(
    __global const uint* counts, uint count, __global uint* first, __global uint* counters,
    uint counter) {
  __local uint room[2 * CC_SCAN_GROUP];
  const uint lid = get_local_id(0), each = (count + CC_SCAN_GROUP - 1) / CC_SCAN_GROUP;
  const uint begin = min(lid * each, count), end = min(begin + each, count);
  uint sum = 0;
  for (uint k = begin; k < end; ++k) sum += counts[k];
  uint run = ccSumUpTo(room, sum) - sum;
  for (uint k = begin; k < end; ++k) {
    first[k] = run;
    run += counts[k];
  }
  if (lid == CC_SCAN_GROUP - 1) {
    first[count] = run;
    counters[counter] = run;
  }
}
