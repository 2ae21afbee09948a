// Sums of bins: four work-items share a bin and its vectors (1, x, y, z), hit_sums.h. Bins with as
// many hits lie side by side, and no bin waits for another.

// A work-item's part of the sums of hits of one body: what it says of each is true of lane 0, and
// behind the bar of lane 1 + j, with p and q the axes behind j.
typedef struct {
  double area, faced;                   // times 1 | x_j
  double normalOwn[3], normalOther[3];  // times 1 | x_j
  double apartOrSecond[3];              // (n + m)_i | x_i x_j, by i
  double push[3];                       // n_i | n_q x_p, n_p x_q, walls' n_j
  // (n + m)_i x_i | lane 1: powers, lane 2: areas of whole samples, depths
  double more[3];
} CcLane;

// One hit more, of depth `depth` at the sample.
void ccAddToLane(CcLane* sums, const CcWeights* h, const float* own, const float* other,
                 const CcWet* wet, float depth, double perUnit, int lane) {
  const int far = lane > 0, j = lane - 1;
  const double n[3] = {own[0], own[1], own[2]}, m[3] = {other[0], other[1], other[2]};
  const double x = h->x[0], y = h->x[1], z = h->x[2];
  const double v = j == 0 ? x : j == 1 ? y : j == 2 ? z : 1.0;
  sums->area += h->w * v;
  sums->faced += h->f * v;
  for (int i = 0; i < 3; ++i) {
    sums->normalOwn[i] += h->w * n[i] * v;
    sums->normalOther[i] += h->w * m[i] * v;
  }
  const double nj = j == 0 ? n[0] : j == 1 ? n[1] : n[2];
  const double np = j == 0 ? n[1] : j == 1 ? n[2] : n[0], xp = j == 0 ? y : j == 1 ? z : x;
  const double nq = j == 0 ? n[2] : j == 1 ? n[0] : n[1], xq = j == 0 ? z : j == 1 ? x : y;
  sums->push[0] += h->pressed * (far ? nq : n[0]) * (far ? xp : 1.0);
  sums->push[1] += h->pressed * (far ? np : n[1]) * (far ? xq : 1.0);
  sums->push[2] += (far ? h->blind : h->pressed) * (far ? nj : n[2]);
  const double power[3] = {j == 0 ? h->pressed : h->w * h->whole,
                           j == 0 ? h->weighed * wet->depth2 : h->f * (depth * perUnit),
                           h->weighed * perUnit * wet->depth3};
  for (int i = 0; i < 3; ++i) {
    const double apart = h->f * (n[i] + m[i]);
    sums->apartOrSecond[i] += far ? h->w * h->x[i] * v : apart;
    sums->more[i] += far ? power[i] : apart * h->x[i];
  }
}

// Adds to a sum, of which the first of two sides is the first to tell.
void ccTell(__global double* to, double more, int again) {
  *to = (again ? *to : 0.0) + more;
}

// What was added, in lengths of `unit` [m], goes to `sums`: of side 0, then of side 1.
void ccGiveLane(__global CcSums* sums, const CcLane* from, int side, double unit, int lane) {
  const double u2 = unit * unit, u3 = u2 * unit, u4 = u2 * u2;
  __global CcSideSums* to = &sums->side[side];
  if (lane == 0) {
    for (int i = 0; i < 3; ++i) {
      ccTell(&sums->normal[side][i], u2 * from->normalOwn[i], side);
      ccTell(&sums->normal[1 - side][i], u2 * from->normalOther[i], side);
      ccTell(&sums->apart[i], u3 * from->apartOrSecond[i], side);
      ccTell(&to->push[i], u3 * from->push[i], 0);
    }
    ccTell(&sums->area, u2 * from->area, side);
    ccTell(&sums->facing, u3 * from->faced, side);
    ccTell(&to->depth[0], u3 * from->faced, 0);
    ccTell(&sums->opening, u4 * (from->more[0] + from->more[1] + from->more[2]), side);
    return;
  }
  const int j = lane - 1;
  ccTell(&sums->first[j], u3 * from->area, side);
  ccTell(&sums->place[j], u4 * from->faced, side);
  for (int i = 0; i < 3; ++i) {
    ccTell(&sums->second[3 * j + i], u4 * from->apartOrSecond[i], side);
    ccTell(&sums->normalBy[side][3 * j + i], u3 * from->normalOwn[i], side);
    ccTell(&sums->normalBy[1 - side][3 * j + i], u3 * from->normalOther[i], side);
  }
  // The vector that belongs to a matrix n x^T: sum of x cross n.
  ccTell(&to->moment[j], u4 * (from->push[0] - from->push[1]), 0);
  ccTell(&to->wall[j], u3 * from->push[2], 0);
  if (j == 0) {
    ccTell(&to->size, u3 * from->more[0], 0);
    ccTell(&to->depth[1], u4 * from->more[1], 0);
    ccTell(&to->depth[2], u4 * unit * from->more[2], 0);
  } else if (j == 1) {
    ccTell(&sums->width, u4 * from->more[0], side);
    ccTell(&sums->middle, u4 * from->more[1], side);
  }
}

__kernel __attribute__((reqd_work_group_size(CC_GROUP, 1, 1))) void ccSums(
    __global const CcPair* pairs, __global const CcDirection* directions,
    __global const CcFound* found, __global const CcAnswer* answers, __global const float4* hits,
    __global const uint* order, __global const CcBin* bins, __global const uint* queue,
    __global const uint* counters, uint binRoom, __global CcSums* sums) {
  const int lane = (int)get_local_id(0) & 3;
  const uint all = min(counters[CC_BINS], binRoom);
  for (uint place = get_global_id(0) / 4; place < all; place += get_global_size(0) / 4) {
    const uint b = queue[place];
    if (b == CC_NO_BIN) continue;
    const CcBin bin = bins[b];
    const int level = answers[bin.pair].level;
    const double cell = pairs[bin.pair].cell * (level == CC_LEVELS - 1 ? 2.0 : 1.0);
    const double perUnit = 1.0 / cell;
    const double origin[3] = {(bin.cell[0] + 0.5) * cell, (bin.cell[1] + 0.5) * cell,
                              (bin.cell[2] + 0.5) * cell};
    __global const uint* list = order + directions[2 * bin.pair].hits;
    double deep = 0.0;
    float deepest = -1e30f;
    for (uint side = 0; side < 2; ++side) {
      const uint end = side == 0 ? bin.middle : bin.end;
      __global const CcDirection* way = &directions[2 * bin.pair + side];
      __global const CcFound* f = &found[(2 * bin.pair + side) * CC_LEVELS + (uint)level];
      __global const float4* here = hits + 4 * (size_t)way->hits;
      const size_t room = way->room;
      const uint below = f->whole, above = f->whole + f->deep;
      CcLane adding = {0.0,
                       0.0,
                       {0.0, 0.0, 0.0},
                       {0.0, 0.0, 0.0},
                       {0.0, 0.0, 0.0},
                       {0.0, 0.0, 0.0},
                       {0.0, 0.0, 0.0}};
      uint i = side == 0 ? bin.begin : bin.middle;
      // The next two hits are on their way while one is added up: memory is far.
      uint at = i < end ? list[i] : 0u, next = i + 1 < end ? list[i + 1] : at,
           last = i + 2 < end ? list[i + 2] : next;
      float4 p1 = here[at], q1 = here[room + at], r1 = here[2 * room + at],
             s1 = here[3 * room + at];
      float4 p2 = here[next], q2 = here[room + next], r2 = here[2 * room + next],
             s2 = here[3 * room + next];
      for (; i < end; ++i) {
        const uint number = at;
        const float4 p = p1, q = q1, r = r1, s = s1;
        at = next;
        next = last;
        if (i + 3 < end) last = list[i + 3];
        p1 = p2, q1 = q2, r1 = r2, s1 = s2;
        p2 = here[next];
        q2 = here[room + next];
        r2 = here[2 * room + next];
        s2 = here[3 * room + next];
        const float x[3] = {p.x, p.y, p.z}, own[3] = {q.x, q.y, q.z}, other[3] = {r.x, r.y, r.z};
        const CcWet wet = {s.x, 0.0f, s.y, s.z, s.w};
        const CcWeights h = ccWeightsOf(x, r.w, &wet, ccGate(q.w), origin, perUnit);
        ccAddToLane(&adding, &h, own, other, &wet, p.w, perUnit, lane);
        deepest = ccMax(deepest, p.w);
        if (number >= below && number < above) deep += (double)r.w * s.y;
      }
      ccGiveLane(&sums[b], &adding, (int)side, cell, lane);
    }
    if (lane < 3) sums[b].origin[lane] = lane == 0 ? origin[0] : lane == 1 ? origin[1] : origin[2];
    if (lane == 3) {
      sums[b].deepest = deepest;
      sums[b].deep = deep;
      sums[b].hits = (int)(bin.end - bin.begin);
      sums[b].unused = 0;
    }
  }
}
