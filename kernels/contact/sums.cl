// Sums bins, a team for each bin and half a team for the hits of each body. Each work-item weighs
// one hit. Then each sums one row over all hits: a product of two numbers times (1, x, y, z), and
// one more number. These are the sums of hit_sums.h with the same products.
//
// A shape has no samples: each hit of the cloud also stands for the shape's surface. Then both halves
// take all hits, and the shape's half takes the other body's normals for its own.

#define CC_HALF (CC_TEAM / 2)

// Numbers of a hit. Their count is odd, so that neighbors are in different banks.
#define CC_ONE 0
#define CC_W 1
#define CC_F 2
#define CC_HIT_PRESSED 3
#define CC_X 4
#define CC_OWN 7
#define CC_OTHER 10
#define CC_HIT_APART 13  // f (n + m)_i, and times x_i
#define CC_HIT_OPENS 16
#define CC_HIT_WALL 19
#define CC_HIT_SQUARE 22
#define CC_HIT_CUBE 23
#define CC_HIT_WIDTH 24
#define CC_HIT_MIDDLE 25
#define CC_HIT_DEPTH 26
#define CC_HIT_NUMBERS 27

// Offsets after those of CcSums (hit_sums.h), for intermediate sums.
#define CC_TURNING 79  // matrix n x^T of a body's hits
#define CC_OPENS_BY 88
#define CC_NOWHERE 91
#define CC_SUMS_ROOM 92

// What a work-item sums over hits, and where the sums go.
typedef struct {
  int a, b, more;           // numbers of a hit
  int to, toRow, step;      // of the product; of it times x, y and z
  int toMore;
  double by, byRow, byMore;  // powers of the unit
} CcRow;

// The row of a work-item in its half of the team.
CcRow ccRowOf(int row, int side, double unit) {
  const double u2 = unit * unit, u3 = u2 * unit, u4 = u2 * u2;
  const int own = CC_SIDES + CC_SIDE_NUMBERS * side;
  CcRow r = {CC_ONE, CC_ONE, CC_ONE, CC_NOWHERE, CC_NOWHERE, 0, CC_NOWHERE, u3, u4, u3};
  const int i = (row + 1) % 3;  // of three rows
  if (row == 0) {
    r.a = CC_W, r.to = CC_AREA, r.by = u2, r.toRow = CC_FIRST, r.step = 1, r.byRow = u3;
  } else if (row == 1) {
    r.a = CC_F, r.to = CC_PRESSED, r.toRow = CC_PLACES, r.step = 1;
  } else if (row < 5) {
    r.a = CC_W, r.b = CC_X + i, r.toRow = CC_SECOND + i, r.step = 3;
  } else if (row < 11) {
    const int whose = row < 8 ? side : 1 - side;
    r.a = CC_W, r.b = (row < 8 ? CC_OWN : CC_OTHER) + i;
    r.to = CC_NORMALS + 3 * whose + i, r.by = u2;
    r.toRow = CC_NORMALS_BY + 9 * whose + i, r.step = 3, r.byRow = u3;
  } else if (row < 14) {
    r.a = CC_HIT_PRESSED, r.b = CC_OWN + i;
    r.to = own + i, r.toRow = CC_TURNING + 3 * i, r.step = 1, r.byRow = 1.0;
  }
  const int k = row % 3;
  if (row < 3) {
    r.more = CC_HIT_APART + k, r.toMore = CC_APART + k;
  } else if (row < 6) {
    r.more = CC_HIT_OPENS + k, r.toMore = CC_OPENS_BY + k, r.byMore = 1.0;
  } else if (row < 9) {
    r.more = CC_HIT_WALL + k, r.toMore = own + CC_WALL + k;
  } else if (row == 9) {
    r.more = CC_HIT_PRESSED, r.toMore = own + CC_SIZE;
  } else if (row == 10) {
    r.more = CC_HIT_SQUARE, r.toMore = own + CC_DEPTHS + 1, r.byMore = u4;
  } else if (row == 11) {
    r.more = CC_HIT_CUBE, r.toMore = own + CC_DEPTHS + 2, r.byMore = u4 * unit;
  } else if (row == 12) {
    r.more = CC_HIT_WIDTH, r.toMore = CC_WIDTH, r.byMore = u4;
  } else if (row == 13) {
    r.more = CC_HIT_MIDDLE, r.toMore = CC_MIDDLE, r.byMore = u4;
  } else if (row == 15) {
    r.more = CC_HIT_DEPTH, r.toMore = CC_DEEPEST, r.byMore = 1.0;
  }
  return r;
}

// One body's hits of a pair.
typedef struct {
  __global const float4* hits;
  __global const uint* list;  // their numbers, bin by bin
  size_t room;
  uint below, above;  // hits from `below` to `above` are below the band
  int mirrored;       // the half of a shape
} CcSideHits;

CcSideHits ccSideHitsOf(uint pair, uint side, int level, __global const CcPair* pairs,
                        __global const CcFound* found, __global const float4* hits,
                        __global const uint* order) {
  __global const CcTerms* terms = &pairs[pair].terms;
  const uint from = terms->oneSided ? (uint)terms->sampled : side;
  __global const CcDirection* way = &pairs[pair].ways[from];
  __global const CcFound* f = &found[(2 * pair + from) * CC_LEVELS + (uint)level];
  const CcSideHits s = {hits + 4 * (size_t)way->hits, order + pairs[pair].ways[0].hits, way->room,
                        f->whole, f->whole + f->deep, from != side};
  return s;
}

// A hit, read ahead of its use.
typedef struct {
  float4 p, q, r, v;
} CcComing;

CcComing ccFetchHit(const CcSideHits* s, uint at) {
  CcComing c = {s->hits[at], s->hits[s->room + at], s->hits[2 * s->room + at],
                s->hits[3 * s->room + at]};
  if (s->mirrored) {
    const float4 q = c.q;
    c.q = (float4)(c.r.xyz, q.w);
    c.r = (float4)(q.xyz, c.r.w);
  }
  return c;
}

// Computes a hit's numbers.
void ccWeighHit(const CcComing* hit, const double* origin, double perUnit, __local double* to) {
  const float4 p = hit->p, q = hit->q, r = hit->r, v = hit->v;
  const float at3[3] = {p.x, p.y, p.z};
  const double own[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
  const CcWet wet = {v.x, 0.0f, v.y, v.z, v.w};
  const CcWeights h = ccWeightsOf(at3, r.w, &wet, ccGate(q.w, p.w), origin, perUnit);
  to[CC_ONE] = 1.0;
  to[CC_W] = h.w;
  to[CC_F] = h.f;
  to[CC_HIT_PRESSED] = h.pressed;
  for (int k = 0; k < 3; ++k) {
    const double apart = h.f * (own[k] + other[k]);
    to[CC_X + k] = h.x[k];
    to[CC_OWN + k] = own[k];
    to[CC_OTHER + k] = other[k];
    to[CC_HIT_APART + k] = apart;
    to[CC_HIT_OPENS + k] = apart * h.x[k];
    to[CC_HIT_WALL + k] = h.blind * own[k];
  }
  to[CC_HIT_SQUARE] = h.weighed * wet.depth2;
  to[CC_HIT_CUBE] = h.weighed * perUnit * wet.depth3;
  to[CC_HIT_WIDTH] = h.w * h.whole;
  to[CC_HIT_MIDDLE] = h.f * (p.w * perUnit);
  to[CC_HIT_DEPTH] = p.w;
}

// The sums of a work-item.
typedef struct {
  double sum, row[3], more;
} CcRowSums;

// Sums a work-item's row over `count` hits from `hit` on. The last row takes the maximum of depths.
void ccAddHits(CcRowSums* sums, const CcRow* r, __local const double* hit, uint count, int row) {
  for (; count > 0; --count, hit += CC_HIT_NUMBERS) {
    const double product = hit[r->a] * hit[r->b], more = hit[r->more];
    sums->sum += product;
    for (int k = 0; k < 3; ++k) sums->row[k] += product * hit[CC_X + k];
    sums->more = row == CC_HALF - 1 ? ccMax64(sums->more, more) : sums->more + more;
  }
}

// Writes a row's sums to a body's part.
void ccGiveRow(__local double* to, const CcRow* r, const CcRowSums* from) {
  if (r->to != CC_NOWHERE) to[r->to] = 0.0 + r->by * from->sum;
  if (r->toRow != CC_NOWHERE)
    for (int k = 0; k < 3; ++k) to[r->toRow + r->step * k] = 0.0 + r->byRow * from->row[k];
  if (r->toMore != CC_NOWHERE) to[r->toMore] = 0.0 + r->byMore * from->more;
}

// Adds the pressed volume of hits below the band to `before`; few pairs have such hits.
double ccAddDeep(const CcSideHits* s, uint begin, uint end, double before) {
  if (s->above == s->below) return before;
  for (uint i = begin; i < end; ++i) {
    const uint k = s->list[i];
    if (k >= s->below && k < s->above)
      before += (double)s->hits[2 * s->room + k].w * s->hits[3 * s->room + k].y;
  }
  return before;
}

// The sum of x cross n, from the matrix n x^T.
double ccTurningOf(__local const double* part, int j) {
  const int p = (j + 1) % 3, q = (j + 2) % 3;
  return part[CC_TURNING + 3 * q + p] - part[CC_TURNING + 3 * p + q];
}

// The n-th number of CcSums, from both bodies' parts; `unit4` [m^4]. `only`: the body with samples,
// or -1. Of the other's part then only its pushes count.
double ccSumOf(int n, __local const double* parts, double unit4, int only) {
  __local const double *a = parts, *b = parts + CC_SUMS_ROOM;
  const int ofA = n < CC_SIDES + CC_SIDE_NUMBERS, k = n - CC_SIDES - (ofA ? 0 : CC_SIDE_NUMBERS);
  if (n < CC_AREA) {
    if (k >= CC_MOMENT && k < CC_WALL)
      return 0.0 + unit4 * ccTurningOf(ofA ? a : b, k - CC_MOMENT);
    const int at = k == CC_DEPTHS ? CC_PRESSED : n;
    return ofA ? a[at] : b[at];
  }
  if (only >= 0) {
    __local const double* own = only == 0 ? a : b;
    return n == CC_OPENING ? 0.0 + unit4 * (own[CC_OPENS_BY] + own[CC_OPENS_BY + 1] +
                                            own[CC_OPENS_BY + 2])
           : n == CC_HITS ? a[n]
                          : own[n];
  }
  if (n == CC_OPENING) {
    a += CC_OPENS_BY, b += CC_OPENS_BY;
    return (0.0 + unit4 * (a[0] + a[1] + a[2])) + unit4 * (b[0] + b[1] + b[2]);
  }
  return n == CC_DEEPEST ? ccMax64(a[n], b[n]) : n == CC_HITS ? a[n] : a[n] + b[n];
}

// Sums every CC_TEAMS_A_PAIR-th bin of a pair. The next bin and its first hits are read while a bin
// is summed.
__kernel __attribute__((reqd_work_group_size(CC_TEAM, 1, 1))) void ccSums(
    __global const CcPair* pairs, __global const CcFound* found,
    __global const CcResults* results, __global const float4* hits, __global const uint* order,
    __global const CcBin* allBins, __global double* allSums) {
  __global const CcAnswer* answers = results->answers;
  __local double weighed[CC_TEAM * CC_HIT_NUMBERS], parts[2 * CC_SUMS_ROOM];
  const int lane = (int)get_local_id(0), row = lane % CC_HALF, side = lane / CC_HALF;
  const uint p = get_group_id(0) / CC_TEAMS_A_PAIR;
  const uint all = answers[p].failed ? 0u : answers[p].bins;
  if (get_group_id(0) % CC_TEAMS_A_PAIR >= all) return;
  __global const CcBin* bins = allBins + answers[p].firstBin;
  __global double* sums = allSums + (size_t)answers[p].firstBin * CC_SUMS_NUMBERS;
  const int level = answers[p].level;
  const double cell = pairs[p].cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0), perUnit = 1.0 / cell;
  const double unit2 = cell * cell, unit4 = unit2 * unit2;
  const CcSideHits s = ccSideHitsOf(p, (uint)side, level, pairs, found, hits, order);
  const CcRow r = ccRowOf(row, side, cell);
  const int oneSided = pairs[p].terms.oneSided, only = oneSided ? pairs[p].terms.sampled : -1;
  uint b = get_group_id(0) % CC_TEAMS_A_PAIR;
  CcBin bin = bins[b];
  uint begin = oneSided || side == 0 ? bin.begin : bin.middle,
       end = oneSided || side == 1 ? bin.end : bin.middle;
  // Without a hit, reads another of the pair's hits, which is not used.
  CcComing coming = ccFetchHit(&s, begin + (uint)row < end ? s.list[begin + (uint)row] : 0u);
  for (; b < all; b += CC_TEAMS_A_PAIR) {
    const CcBin next = bins[min(b + CC_TEAMS_A_PAIR, all - 1u)];
    const double origin[3] = {(bin.cell[0] + 0.5) * cell, (bin.cell[1] + 0.5) * cell,
                              (bin.cell[2] + 0.5) * cell};
    const uint nextBegin = oneSided || side == 0 ? next.begin : next.middle,
               nextEnd = oneSided || side == 1 ? next.end : next.middle;
    CcRowSums adding = {0.0, {0.0, 0.0, 0.0}, row == CC_HALF - 1 ? -1e30f : 0.0};
    ccWeighHit(&coming, origin, perUnit, weighed + lane * CC_HIT_NUMBERS);
    const uint nextAt = nextBegin + (uint)row < nextEnd ? s.list[nextBegin + (uint)row] : 0u;
    barrier(CLK_LOCAL_MEM_FENCE);
    ccAddHits(&adding, &r, weighed + side * CC_HALF * CC_HIT_NUMBERS,
              min(end - begin, (uint)CC_HALF), row);
    coming = ccFetchHit(&s, nextAt);
    const uint most = oneSided ? bin.end - bin.begin
                               : max(bin.middle - bin.begin, bin.end - bin.middle);
    for (uint done = CC_HALF; done < most; done += CC_HALF) {
      barrier(CLK_LOCAL_MEM_FENCE);
      if (begin + done + (uint)row < end) {
        const CcComing more = ccFetchHit(&s, s.list[begin + done + (uint)row]);
        ccWeighHit(&more, origin, perUnit, weighed + lane * CC_HIT_NUMBERS);
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      ccAddHits(&adding, &r, weighed + side * CC_HALF * CC_HIT_NUMBERS,
                begin + done < end ? min(end - begin - done, (uint)CC_HALF) : 0u, row);
    }
    ccGiveRow(parts + side * CC_SUMS_ROOM, &r, &adding);
    if (lane < 3) parts[lane] = lane == 0 ? origin[0] : lane == 1 ? origin[1] : origin[2];
    if (lane == 3) parts[CC_HITS] = as_double((ulong)(bin.end - bin.begin));
    if (lane == 4) parts[CC_DEEP_PRESSED] = ccAddDeep(&s, begin, end, 0.0);
    barrier(CLK_LOCAL_MEM_FENCE);
    __global double* to = sums + (size_t)b * CC_SUMS_NUMBERS;
    for (int n = lane; n < CC_SUMS_NUMBERS; n += CC_TEAM)
      if (n != CC_DEEP_PRESSED) to[n] = ccSumOf(n, parts, unit4, only);
    if (lane == CC_HALF) to[CC_DEEP_PRESSED] = ccAddDeep(&s, begin, end, parts[CC_DEEP_PRESSED]);
    bin = next;
    begin = nextBegin;
    end = nextEnd;
  }
}
