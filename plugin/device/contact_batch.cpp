// ContactBatch: which pairs go to the device, and what the CPU does for all.
#include <cloudcontact/device/contact_batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <new>
#include <optional>
#include <stdexcept>

#include "contact/finder_scratch.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_batch.h"
#endif

namespace cloudcontact {

namespace {

// Parts that a step's pairs are asked for in, and how many pairs are worth one.
constexpr std::size_t kParts = 2, kWorthAPart = 32;
// Hits that a direction is first given room for, and the most that it is given.
constexpr std::uint32_t kFirstRoom = 2048, kMoreRoom = 4, kMostRoom = 1u << 20;

// Whether a device has the memory for some work.
template <typename Work>
bool fits(Work&& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

}  // namespace

struct ContactBatch::Inside {
  BatchSettings settings;
  std::string message, name;
  tbb::task_arena arena;
  std::deque<ContactFinder> finders;
  std::vector<std::uint32_t> rooms;  // of each pair, as it was found to need
  std::vector<const ContactResult*> results;
  std::vector<std::size_t> here;  // pairs for the CPU
  BatchReport report;
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::shared_ptr<opencl::DeviceFields> fields;
  // Some of the pairs that are asked, in a queue of their own.
  struct Part {
    opencl::OpenClBatch batch;
    std::size_t first = 0, count = 0;
    std::vector<std::size_t> here;  // as that of all
    BatchReport report;

    Part(const std::shared_ptr<opencl::Device>& device,
         const std::shared_ptr<opencl::DeviceFields>& fields)
        : batch(device, fields) {}
  };
  std::deque<Part> parts;
  std::vector<opencl::Asked> asked;
  std::vector<std::size_t> numbers;  // of the pairs that are asked

  void open();
  void onDevice(std::span<const BatchPair> pairs);
  void askParts();
  void wake(std::size_t pairs);
  void finish(Part& part);
  void prepare(Part& part, bool placed);
  bool ask(Part& part);
  void askHalves(Part& part, std::size_t first, std::size_t count);
  std::span<const opencl::Asked> pairsOf(const Part& part) const {
    return std::span(asked).subspan(part.first, part.count);
  }
  // What some pairs came to.
  struct Taken {
    std::size_t asked = 0, hits = 0, failed = 0;
    int finest = kLevels - 1;
  };
  void take(Part& part);
  void takeOne(Part& part, std::size_t i, Taken& taken);
  void settle(Part& part);
#endif

  explicit Inside(const BatchSettings& how);
  void onCpu(std::span<const BatchPair> pairs);

  template <typename Function, typename Partitioner = tbb::auto_partitioner>
  void each(std::size_t count, const Function& function, const Partitioner& shares = {}) {
    arena.execute([&] {
      // A thread that waits here must not begin with other work of the caller's.
      tbb::this_task_arena::isolate(
          [&] { tbb::parallel_for(std::size_t{0}, count, function, shares); });
    });
  }
  // Where all take as long: shares are not told out, and a pair comes to the thread that had it
  // before. On 16 cores 340 pairs' results took 45 us so, 70 to 95 by each().
  template <typename Function>
  void eachAlike(std::size_t count, const Function& function) {
    each(count, function, tbb::static_partitioner{});
  }
};

ContactBatch::Inside::Inside(const BatchSettings& how)
    : settings(how), arena(how.threads > 0 ? how.threads : tbb::task_arena::automatic) {
  if (settings.backend == Backend::Cpu) return;
#if defined(CLOUDCONTACT_OPENCL)
  try {
    open();
    return;
  } catch (const std::runtime_error& e) {
    message = e.what();
  }
#else
  message =
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again";
#endif
  message = "contacts are found on the CPU: " + message;
  settings.backend = Backend::Cpu;
}

void ContactBatch::Inside::onCpu(std::span<const BatchPair> pairs) {
  each(here.size(), [&](std::size_t i) {
    const std::size_t k = here[i];
    results[k] = &finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings);
  });
  ContactFinder::makeRoom(arena.max_concurrency());
  report.onCpu += here.size();
}

#if defined(CLOUDCONTACT_OPENCL)

void ContactBatch::Inside::open() {
  device = opencl::Device::open(settings.timing);
  fields = std::make_shared<opencl::DeviceFields>(device);
  for (std::size_t k = 0; k < kParts; ++k) parts.emplace_back(device, fields);
  name = device->name();
}

void ContactBatch::Inside::onDevice(std::span<const BatchPair> pairs) {
  wake(pairs.size());
  asked.clear();
  numbers.clear();
  for (Part& part : parts) {  // a call that threw may have left something
    part.here.clear();
    part.report = {};
  }
  // Pairs of the same two fields nearly always follow each other: a field is asked for once, not
  // looked up 2,048 times.
  const SurfaceField* fieldOf[2] = {nullptr, nullptr};
  std::uint32_t numberOf[2] = {0, 0};
  const auto number = [&](const ContactBody& body, int side) {
    if (body.field == fieldOf[side]) return;
    fieldOf[side] = body.field;
    numberOf[side] = opencl::guarded(
        name, [&] { return fields->numberOf(static_cast<const FieldData&>(*body.field)); });
  };
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (pairs[k].a.shape || pairs[k].b.shape) {
      here.push_back(k);
      ++report.shapes;
      continue;
    }
    if (!pairs[k].a.field || !pairs[k].b.field)  // throws, and says which
      ContactFinder::Scratch::of(finders[k]).begin(pairs[k].a, pairs[k].b);
    number(pairs[k].a, 0);
    number(pairs[k].b, 1);
    asked.push_back({&pairs[k], {}, rooms[k], {numberOf[0], numberOf[1]}});
    numbers.push_back(k);
  }
  opencl::guarded(name, [&] { fields->settle(); });
  askParts();
}

// In parts, each in a queue of its own: the CPU prepares and finishes some pairs while the device
// works on others, and kernels in which pairs wait for themselves run beside those that fill the
// device. All searches are handed over before anything else: a kernel takes 10 us to hand over, and
// the device waited for a last part that was begun behind another's whole chain. On an H100 1,024
// pairs took 0.99 to 1.05 ms so, 1.00 to 1.08 where all were prepared before the first search, 1.19
// to 1.30 in three parts handed over one behind the other. On another host, all prepared first,
// they took 1.07 to 1.14 in two parts, 1.13 to 1.18 in one and 1.16 in three.
void ContactBatch::Inside::askParts() {
  const std::size_t n = asked.size(),
                    // Steps that are timed do not run beside others.
      most = settings.timing ? 1 : kParts, used = std::clamp(n / kWorthAPart, std::size_t{1}, most);
  bool there[kParts] = {};
  try {
    for (std::size_t k = 0; k < used; ++k) {
      Part& part = parts[k];
      part.first = n * k / used;
      part.count = n * (k + 1) / used - part.first;
      there[k] = part.count > 0 && fits([&] { part.batch.place(pairsOf(part)); });
    }
    for (std::size_t k = 0; k < used; ++k) {
      prepare(parts[k], there[k]);
      there[k] = there[k] && fits([&] { parts[k].batch.search(parts[k].report); });
    }
    for (std::size_t k = 0; k < used; ++k)
      there[k] = there[k] && fits([&] { parts[k].batch.gather(); });
    for (std::size_t k = 0; k < used; ++k) {
      if (there[k])
        finish(parts[k]);
      else
        askHalves(parts[k], parts[k].first, parts[k].count);
    }
  } catch (...) {
    // What they were to read and write is to be used again.
    for (Part& part : parts) part.batch.finishQuietly();
    throw;
  }
  for (std::size_t k = 0; k < used; ++k) settle(parts[k]);
}

// All that comes before the device; `placed`: whether the part has room for poses.
void ContactBatch::Inside::prepare(Part& part, bool placed) {
  eachAlike(part.count, [&](std::size_t i) {
    opencl::Asked& one = asked[part.first + i];
    one.frame = ContactFinder::Scratch::of(finders[numbers[part.first + i]])
                    .begin(one.pair->a, one.pair->b);
    if (placed) part.batch.pose(i);
  });
}

// A part of pairs that are prepared; whether the device has room for them.
bool ContactBatch::Inside::ask(Part& part) {
  if (part.count == 0) return true;
  const bool there = fits([&] {
    part.batch.place(pairsOf(part));
    for (std::size_t k = 0; k < part.count; ++k) part.batch.pose(k);
    part.batch.search(part.report);
    part.batch.gather();
  });
  if (there) finish(part);
  return there;
}

// Threads that slept take 50 us to wake: they are called before there is work for them.
void ContactBatch::Inside::wake(std::size_t pairs) {
  const auto threads = static_cast<std::size_t>(arena.max_concurrency());
  for (std::size_t k = 1; k < std::min(threads, pairs); ++k) arena.enqueue([] {});
}

// Threads sleep while the device works, and are called while it is at its last kernels. Without
// that 1,024 pairs took 1.5 to 1.7 ms where they took 1.35 to 1.5 with it.
void ContactBatch::Inside::finish(Part& part) {
  part.batch.nearEnd();
  eachAlike(static_cast<std::size_t>(arena.max_concurrency()), [](std::size_t) {});
  part.batch.finish(part.report);
  take(part);
}

void ContactBatch::Inside::askHalves(Part& part, std::size_t first, std::size_t count) {
  if (count == 1) {
    part.here.push_back(numbers[first]);
    ++part.report.noRoom;
    return;
  }
  for (const bool second : {false, true}) {
    part.first = second ? first + count / 2 : first;
    part.count = second ? count - count / 2 : count / 2;
    if (!ask(part)) askHalves(part, part.first, part.count);
  }
}

void ContactBatch::Inside::take(Part& part) {
  std::atomic<std::size_t> askedOf{0}, hits{0}, failed{0};
  std::atomic<int> finest{kLevels - 1};
  const std::size_t shares =
      std::min(part.count, static_cast<std::size_t>(arena.max_concurrency()));
  eachAlike(shares, [&](std::size_t share) {
    Taken taken;
    const std::size_t end = part.count * (share + 1) / shares;
    for (std::size_t i = part.count * share / shares; i < end; ++i) takeOne(part, i, taken);
    askedOf += taken.asked;
    hits += taken.hits;
    failed += taken.failed;
    for (int had = finest; taken.finest < had;)
      if (finest.compare_exchange_weak(had, taken.finest)) break;
  });
  part.report.asked += askedOf;
  part.report.hits += hits;
  part.batch.learn(finest);
  for (std::size_t i = 0; i < (failed > 0 ? part.count : 0); ++i) {
    const int why = part.batch.answer(i).failed;
    if (!why) continue;
    part.here.push_back(numbers[part.first + i]);
    ++(why & CC_FINER      ? part.report.finer
       : why & CC_NO_TOUCH ? part.report.nearMisses
                           : part.report.noRoom);
  }
}

// What became of a pair: its contacts, and the room that it is given next.
void ContactBatch::Inside::takeOne(Part& part, std::size_t i, Taken& taken) {
  const CcAnswer& answer = part.batch.answer(i);
  const std::size_t k = numbers[part.first + i];
  // What found no room was not counted to its end.
  const std::uint32_t room = answer.failed & CC_NO_ROOM
                                 ? std::max(kMoreRoom * rooms[k], 2 * answer.wanted)
                                 : std::max(rooms[k], answer.wanted + answer.wanted / 4);
  rooms[k] = std::min(room, kMostRoom);
  taken.asked += answer.asked;
  taken.hits += answer.hits;
  taken.finest = std::min(taken.finest, answer.failed & CC_FINER ? 0 : answer.level);
  taken.failed += answer.failed != 0;
  if (answer.failed) return;
  ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[k]);
  finder.result.samples = answer.hits;
  for (const CcContactPatch& contact : part.batch.contacts(i)) finder.take(contact);
  results[k] = &finder.named();
}

// What a part came to goes to what all came to.
void ContactBatch::Inside::settle(Part& part) {
  here.insert(here.end(), part.here.begin(), part.here.end());
  for (std::size_t BatchReport::*number :
       {&BatchReport::noRoom, &BatchReport::finer, &BatchReport::nearMisses, &BatchReport::asked,
        &BatchReport::hits, &BatchReport::bins, &BatchReport::patches, &BatchReport::contacts,
        &BatchReport::sent, &BatchReport::fetched})
    report.*number += part.report.*number;
  part.here.clear();
  part.report = {};
}

#endif

ContactBatch::ContactBatch(const BatchSettings& settings)
    : inside_(std::make_unique<Inside>(settings)) {}
ContactBatch::~ContactBatch() = default;
ContactBatch::ContactBatch(ContactBatch&&) noexcept = default;
ContactBatch& ContactBatch::operator=(ContactBatch&&) noexcept = default;

Backend ContactBatch::backend() const {
  return inside_->settings.backend;
}
const std::string& ContactBatch::message() const {
  return inside_->message;
}
const std::string& ContactBatch::device() const {
  return inside_->name;
}
const BatchReport& ContactBatch::report() const {
  return inside_->report;
}

std::span<const ContactResult* const> ContactBatch::find(std::span<const BatchPair> pairs) {
  Inside& s = *inside_;
  s.report = {};
  s.here.clear();
  s.results.assign(pairs.size(), nullptr);
  while (s.finders.size() < pairs.size()) s.finders.emplace_back();
  s.rooms.resize(std::max(s.rooms.size(), pairs.size()), kFirstRoom);
#if defined(CLOUDCONTACT_OPENCL)
  if (s.device) {
    s.onDevice(pairs);
    s.onCpu(pairs);
    s.report.onDevice = pairs.size() - s.here.size();
    return s.results;
  }
#endif
  for (std::size_t k = 0; k < pairs.size(); ++k) s.here.push_back(k);
  s.onCpu(pairs);
  return s.results;
}

std::size_t ContactBatch::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  std::size_t sum = inside_->fields ? inside_->fields->bytes() : 0;
  for (const auto& part : inside_->parts) sum += part.batch.bytes();
  return sum;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> ContactBatch::deviceTimes() {
  std::map<std::string, DeviceTime> times;
#if defined(CLOUDCONTACT_OPENCL)
  if (inside_->device)
    for (const auto& [name, spent] : inside_->device->clock())
      times[name] = {spent.seconds, spent.calls};
#endif
  return times;
}

}  // namespace cloudcontact
