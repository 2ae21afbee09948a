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

// Hits that a direction is first given room for, and the most that it is given.
constexpr std::size_t kParts = 2, kWorthAPart = 128;
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
  std::deque<opencl::OpenClBatch> batches;
  std::vector<opencl::Asked> asked;
  std::vector<std::size_t> numbers;  // of the pairs that are asked

  void open();
  void onDevice(std::span<const BatchPair> pairs);
  void askParts();
  void ask(std::size_t first, std::size_t count);
  bool start(opencl::OpenClBatch& batch, std::size_t first, std::size_t count);
  void finish(opencl::OpenClBatch& batch, std::size_t first, std::size_t count);
  void take(const opencl::OpenClBatch& batch, std::size_t first, std::size_t count);
#endif

  explicit Inside(const BatchSettings& how);
  void onCpu(std::span<const BatchPair> pairs);

  template <typename Function>
  void each(std::size_t count, const Function& function) {
    arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, function); });
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
  for (std::size_t k = 0; k < kParts; ++k) batches.emplace_back(device, fields);
  name = device->name();
}

void ContactBatch::Inside::onDevice(std::span<const BatchPair> pairs) {
  asked.clear();
  numbers.clear();
  // Pairs of the same two fields nearly always follow each other: a field is asked for once, not
  // looked up 2,048 times.
  const SurfaceField* fieldOf[2] = {nullptr, nullptr};
  std::uint32_t numberOf[2] = {0, 0};
  const auto number = [&](const ContactBody& body, int side) {
    if (body.field == fieldOf[side]) return;
    fieldOf[side] = body.field;
    numberOf[side] = fields->numberOf(static_cast<const FieldData&>(*body.field));
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
  fields->settle();
  askParts();
}

// In parts, each in a queue of its own: the CPU prepares and finishes one while the device works on
// the others, and kernels in which pairs wait for themselves run beside those that fill the device.
void ContactBatch::Inside::askParts() {
  const std::size_t n = asked.size(), parts = n < kParts * kWorthAPart ? 1 : kParts;
  bool started[kParts] = {};
  for (std::size_t k = 0; k < parts; ++k)
    started[k] = start(batches[k], n * k / parts, n * (k + 1) / parts - n * k / parts);
  for (std::size_t k = 0; k < parts; ++k)
    if (started[k]) finish(batches[k], n * k / parts, n * (k + 1) / parts - n * k / parts);
  for (std::size_t k = 0; k < parts; ++k)
    if (!started[k]) ask(n * k / parts, n * (k + 1) / parts - n * k / parts);
}

// What is too large for the device is asked for in halves.
void ContactBatch::Inside::ask(std::size_t first, std::size_t count) {
  if (count == 0) return;
  if (start(batches[0], first, count)) return finish(batches[0], first, count);
  if (count > 1) {
    ask(first, count / 2);
    return ask(first + count / 2, count - count / 2);
  }
  here.push_back(numbers[first]);
  ++report.noRoom;
}

// Whether the device has room for them.
bool ContactBatch::Inside::start(opencl::OpenClBatch& batch, std::size_t first, std::size_t count) {
  // One loop over the pairs for all that comes before the device.
  const opencl::Each all = [&](std::size_t n, const std::function<void(std::size_t)>& function) {
    each(n, [&](std::size_t i) {
      opencl::Asked& one = asked[first + i];
      ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[numbers[first + i]]);
      one.frame = finder.begin(one.pair->a, one.pair->b);
      function(i);
    });
  };
  try {
    batch.start(std::span(asked).subspan(first, count), all, report);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void ContactBatch::Inside::finish(opencl::OpenClBatch& batch, std::size_t first,
                                  std::size_t count) {
  batch.finish(report);
  take(batch, first, count);
}

void ContactBatch::Inside::take(const opencl::OpenClBatch& batch, std::size_t first,
                                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const CcAnswer& answer = batch.answer(i);
    const std::size_t k = numbers[first + i];
    // What found no room was not counted to its end.
    const std::uint32_t room = answer.failed & CC_NO_ROOM
                                   ? std::max(kMoreRoom * rooms[k], 2 * answer.wanted)
                                   : std::max(rooms[k], answer.wanted + answer.wanted / 4);
    rooms[k] = std::min(room, kMostRoom);
    if (!answer.failed) continue;
    here.push_back(k);
    ++(answer.failed & CC_NO_TOUCH ? report.nearMisses : report.noRoom);
  }
  each(count, [&](std::size_t i) {
    const CcAnswer& answer = batch.answer(i);
    if (answer.failed) return;
    const std::size_t k = numbers[first + i];
    ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[k]);
    finder.result.samples = answer.hits;
    for (const CcContactPatch& contact : batch.contacts(i)) finder.take(contact);
    results[k] = &finder.named();
  });
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
  for (const auto& batch : inside_->batches) sum += batch.bytes();
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
