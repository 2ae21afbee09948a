// What the work-items of a group do together: sums over all before them.

#define CC_WORDS (CC_GROUP / 32)

// The sum of `value` over the work-items up to this one; `room` for two numbers each.
uint ccSumUpTo(__local uint* room, uint value) {
  const uint i = get_local_id(0), n = get_local_size(0);
  uint from = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  room[i] = value;
  for (uint step = 1; step < n; step *= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint sum = room[from + i] + (i >= step ? room[from + i - step] : 0u);
    from = n - from;
    room[from + i] = sum;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return room[from + i];
}

// Flags of all work-items, a bit each, `kinds` of them beside each other.
void ccFlag(__local uint* flags, int kinds, int mine) {
  const uint i = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint k = i; k < (uint)(kinds * CC_WORDS); k += CC_GROUP) flags[k] = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int kind = 0; kind < kinds; ++kind)
    if (mine >> kind & 1) atomic_or(&flags[kind * CC_WORDS + (int)(i >> 5)], 1u << (i & 31u));
  barrier(CLK_LOCAL_MEM_FENCE);
}

// How many work-items before the i-th have the flag.
uint ccFlagged(__local const uint* flags, int kind, uint i) {
  uint count = 0;
  for (uint w = 0; w < CC_WORDS; ++w) {
    const uint word = flags[kind * CC_WORDS + (int)w];
    const uint all = w < (i >> 5) ? ~0u : (w == (i >> 5) ? (1u << (i & 31u)) - 1u : 0u);
    count += popcount(word & all);
  }
  return count;
}

// The first of `count` rising ends that lies beyond k.
uint ccRunOf(__local const uint* ends, uint count, uint k) {
  uint low = 0, high = count;
  while (low < high) {
    const uint middle = (low + high) / 2;
    if (ends[middle] > k)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}
