// Operations of a whole work-group: votes, prefix sums, and flags.

#define CC_WORDS (CC_GROUP / 32)

// The votes of a team's work-items, one bit each; all of the team must call it. `room` is memory of
// the team. On NVIDIA devices a team of 32 runs in step, and one instruction saves three barriers.
#if defined(CC_NVIDIA)
uint ccVotes(__local uint* room, int is) {
  uint votes;
  asm volatile(
      "{ .reg .pred said; setp.ne.s32 said, %1, 0; vote.sync.ballot.b32 %0, said, 0xffffffff; }"
      : "=r"(votes)
      : "r"(is));
  return votes;
}
#else
uint ccVotes(__local uint* room, int is) {
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) *room = 0u;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (is) atomic_or(room, 1u << get_local_id(0));
  barrier(CLK_LOCAL_MEM_FENCE);
  return *room;
}
#endif

// The index of the lowest bit set; one must be.
uint ccLowest(uint bits) {
  return 31u - clz(bits & (0u - bits));
}

// The sum of `value` over the work-items up to this one, first in teams of 32. `room` holds two
// numbers for each work-item. There are no barriers in loops, which PoCL compiles slowly.
uint ccSumUpTo(__local uint* room, uint value) {
  const uint i = get_local_id(0), n = get_local_size(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  room[i] = value;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint sum = 0;
  for (uint k = i & ~31u; k <= i; ++k) sum += room[k];
  if ((i & 31u) == 31u) room[n + (i >> 5)] = sum;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint k = 0; k < i >> 5; ++k) sum += room[n + k];
  return sum;
}

// Flags of all work-items, a bit each, of up to four kinds, and the number of earlier flags of each
// kind. Begin with ccNoFlags().
typedef struct {
  uint words[4 * CC_WORDS], before[4];
} CcFlags;

void ccNoFlags(__local CcFlags* flags) {
  const uint i = get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (i < 4 * CC_WORDS) flags->words[i] = 0u;
  if (i < 4) flags->before[i] = 0u;
}

// Counts the flags set so far as earlier ones.
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

// The number of flags before this work-item's.
uint ccFlagged(__local const CcFlags* flags, uint kind) {
  const uint i = get_local_id(0);
  uint count = flags->before[kind];
  for (uint w = 0; w < (i >> 5); ++w) count += popcount(flags->words[kind * CC_WORDS + w]);
  return count + popcount(flags->words[kind * CC_WORDS + (i >> 5)] & ((1u << (i & 31u)) - 1u));
}

// Flags of a window of items. A work-item has every CC_GROUP-th item, and two kinds of flags: bits
// j and 16 + j of its word are for its j-th item. So the group synchronizes once a window, not once
// an item.
#define CC_ROUNDS 16
#define CC_WINDOW (CC_ROUNDS * CC_GROUP)
#define CC_ROWS (CC_ROUNDS * CC_WORDS)

typedef struct {
  uint words[CC_GROUP];
  uint rows[2 * CC_ROWS];  // 32 items each, in order; then those of the second kind
  uint before[CC_ROWS];    // flags before each row; << 16 of the second kind
  uint all;                // all flags
} CcMarks;

// Sets the flags of all work-items, and `all`. `room` as for ccSumUpTo().
void ccMark(__local CcMarks* marks, __local uint* room, uint mine) {
  const uint i = get_local_id(0), bit = i & 31u, word = i >> 5;
  barrier(CLK_LOCAL_MEM_FENCE);
  marks->words[i] = mine;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint row = 0;
  for (uint k = 0; k < 32; ++k) row |= (marks->words[32 * word + k] >> bit & 1u) << k;
  marks->rows[(bit >> 4) * CC_ROWS + (bit & 15u) * CC_WORDS + word] = row;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint count = 0;
  if (i < CC_ROWS) count = popcount(marks->rows[i]) | popcount(marks->rows[CC_ROWS + i]) << 16;
  const uint upTo = ccSumUpTo(room, count);
  if (i < CC_ROWS) marks->before[i] = upTo - count;
  if (i == CC_GROUP - 1) marks->all = upTo;
  barrier(CLK_LOCAL_MEM_FENCE);
}

// The number of flags of a kind before this work-item's j-th item.
uint ccMarked(__local const CcMarks* marks, uint kind, uint j) {
  const uint i = get_local_id(0), row = j * CC_WORDS + (i >> 5);
  return (marks->before[row] >> 16 * kind & 0xffffu) +
         popcount(marks->rows[kind * CC_ROWS + row] & ((1u << (i & 31u)) - 1u));
}

// The first of `count` ascending ends that is greater than k.
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
