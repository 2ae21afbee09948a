// ContactBatch: which pairs go to the device, and what the CPU does for all.
#include <cloudcontact/batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <deque>
#include <new>
#include <optional>
#include <stdexcept>

#include "contact/finder_scratch.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "opencl_batch.h"
#endif

namespace cloudcontact {

namespace {

// Parts that a step's pairs are asked for in, and how many pairs are worth one.
constexpr std::size_t kParts = 3, kWorthAPart = 32;
// Hits that a direction is first given room for, and the most that it is given.
constexpr std::uint32_t kFirstRoom = 2048, kMoreRoom = 4, kMostRoom = 1u << 20;

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
  bool ask(Part& part);
  void finish(Part& part);
  void askHalves(Part& part, std::size_t first, std::size_t count);
  bool start(Part& part);
  void take(Part& part);
  void settle(Part& part);
#endif

  explicit Inside(const BatchSettings& how);
  void onCpu(std::span<const BatchPair> pairs);

  template <typename Function>
  void each(std::size_t count, const Function& function) {
    arena.execute([&] {
      // A thread that waits here must not begin with other work of the caller's.
      tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, function); });
    });
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

// In parts, each in a queue of its own, one handed over behind the other: the CPU prepares and
// finishes some pairs while the device works on others, and kernels in which pairs wait for
// themselves run beside those that fill the device. 1,024 pairs took 1.30 ms on an H100 in one
// part, 1.20 in two, 1.14 to 1.21 in three, 1.19 to 1.22 in four. With a thread for each part the
// threads waited for each other to hand kernels over, and all parts ended at once.
void ContactBatch::Inside::askParts() {
  const std::size_t n = asked.size(),
                    // Steps that are timed do not run beside others.
      most = settings.timing ? 1 : kParts, used = std::clamp(n / kWorthAPart, std::size_t{1}, most);
  bool started[kParts] = {};
  try {
    for (std::size_t k = 0; k < used; ++k) {
      parts[k].first = n * k / used;
      parts[k].count = n * (k + 1) / used - parts[k].first;
      started[k] = parts[k].count > 0 && start(parts[k]);
    }
    for (std::size_t k = 0; k < used; ++k) {
      if (started[k])
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

// Whether the device has room for them.
bool ContactBatch::Inside::ask(Part& part) {
  if (part.count == 0) return true;
  if (!start(part)) return false;
  finish(part);
  return true;
}

// Threads that slept while the device worked take long to wake: they are called while it is at its
// last kernels. Without that 1,024 pairs took 1.5 to 1.7 ms where they took 1.35 to 1.5 with it.
void ContactBatch::Inside::finish(Part& part) {
  part.batch.nearEnd();
  each(static_cast<std::size_t>(arena.max_concurrency()), [](std::size_t) {});
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

bool ContactBatch::Inside::start(Part& part) {
  // One loop over the pairs for all that comes before the device.
  const opencl::Each all = [&](std::size_t n, const std::function<void(std::size_t)>& function) {
    each(n, [&](std::size_t i) {
      opencl::Asked& one = asked[part.first + i];
      ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[numbers[part.first + i]]);
      one.frame = finder.begin(one.pair->a, one.pair->b);
      function(i);
    });
  };
  try {
    part.batch.start(std::span(asked).subspan(part.first, part.count), all, part.report);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void ContactBatch::Inside::take(Part& part) {
  for (std::size_t i = 0; i < part.count; ++i) {
    const CcAnswer& answer = part.batch.answer(i);
    const std::size_t k = numbers[part.first + i];
    // What found no room was not counted to its end.
    const std::uint32_t room = answer.failed & CC_NO_ROOM
                                   ? std::max(kMoreRoom * rooms[k], 2 * answer.wanted)
                                   : std::max(rooms[k], answer.wanted + answer.wanted / 4);
    rooms[k] = std::min(room, kMostRoom);
    if (!answer.failed) continue;
    part.here.push_back(k);
    ++(answer.failed & CC_FINER      ? part.report.finer
       : answer.failed & CC_NO_TOUCH ? part.report.nearMisses
                                     : part.report.noRoom);
  }
  each(part.count, [&](std::size_t i) {
    const CcAnswer& answer = part.batch.answer(i);
    if (answer.failed) return;
    const std::size_t k = numbers[part.first + i];
    ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[k]);
    finder.result.samples = answer.hits;
    for (const CcContactPatch& contact : part.batch.contacts(i)) finder.take(contact);
    results[k] = &finder.named();
  });
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
