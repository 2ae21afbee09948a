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

// Flags of all work-items, a bit each, `kinds` of them beside each other, and how many had each
// before these. Begins with ccNoFlags().
typedef struct {
  uint words[4 * CC_WORDS], before[4];
} CcFlags;

void ccNoFlags(__local CcFlags* flags) {
  const uint i = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (i < 4 * CC_WORDS) flags->words[i] = 0u;
  if (i < 4) flags->before[i] = 0u;
}

// What was flagged so far counts as before.
void ccCountFlags(__local CcFlags* flags, uint kinds) {
  const uint i = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (i < kinds) {
    uint count = flags->before[i];
    for (uint w = 0; w < CC_WORDS; ++w) {
      count += popcount(flags->words[i * CC_WORDS + w]);
      flags->words[i * CC_WORDS + w] = 0u;
    }
    flags->before[i] = count;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

void ccFlag(__local CcFlags* flags, uint kinds, uint mine) {
  const uint i = get_local_id(0);
  ccCountFlags(flags, kinds);
  for (uint kind = 0; kind < kinds; ++kind)
    if (mine >> kind & 1u) atomic_or(&flags->words[kind * CC_WORDS + (i >> 5)], 1u << (i & 31u));
  barrier(CLK_LOCAL_MEM_FENCE);
}

// How many had the flag before this work-item.
uint ccFlagged(__local const CcFlags* flags, uint kind) {
  const uint i = get_local_id(0);
  uint count = flags->before[kind];
  for (uint w = 0; w < (i >> 5); ++w) count += popcount(flags->words[kind * CC_WORDS + w]);
  return count + popcount(flags->words[kind * CC_WORDS + (i >> 5)] & ((1u << (i & 31u)) - 1u));
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
