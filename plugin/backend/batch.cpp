// ContactBatch: which pairs go to the device, and what the CPU does for all.
#include <cloudcontact/batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <deque>
#include <new>
#include <stdexcept>

#include "contact/finder_scratch.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "opencl_batch.h"
#endif

namespace cloudcontact {

namespace {

// Hits that a direction is first given room for, and the most that it is given.
constexpr std::uint32_t kFirstRoom = 2048, kMoreRoom = 4, kMostRoom = 1u << 20;
// Parts of a batch under way at once, and the pairs that are worth a part. One: a kernel in which
// each pair waits for itself takes as long for few pairs as for many. On an H100 growth took 1.03
// ms in four parts of 256 pairs (0.26 each), and a step 4.0 ms.
constexpr std::size_t kParts = 1, kPartPairs = 128;

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
  std::vector<opencl::OpenClBatch> parts;
  std::vector<PairFrame> frames;
  std::vector<opencl::Asked> asked;
  std::vector<std::size_t> numbers;  // of the pairs that are asked

  void open();
  void onDevice(std::span<const BatchPair> pairs);
  void ask(std::size_t first, std::size_t count, std::size_t inParts);
  void take(const opencl::OpenClBatch& part, std::size_t first, std::size_t count);
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
  frames.resize(pairs.size());
  each(pairs.size(), [&](std::size_t k) {
    frames[k] = ContactFinder::Scratch::of(finders[k]).begin(pairs[k].a, pairs[k].b);
  });
  asked.clear();
  numbers.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (pairs[k].a.shape || pairs[k].b.shape) {
      here.push_back(k);
      ++report.shapes;
      continue;
    }
    const auto number = [&](const ContactBody& body) {
      return fields->numberOf(static_cast<const FieldData&>(*body.field));
    };
    asked.push_back({&pairs[k], frames[k], rooms[k], {number(pairs[k].a), number(pairs[k].b)}});
    numbers.push_back(k);
  }
  fields->settle();
  ask(0, asked.size(), std::clamp<std::size_t>(asked.size() / kPartPairs, 1, kParts));
}

// In parts, so that the CPU finishes one while the device works on the next. A part too large for
// the device is asked for in halves.
void ContactBatch::Inside::ask(std::size_t first, std::size_t count, std::size_t inParts) {
  if (count == 0) return;
  const auto begin = [&](std::size_t part) { return first + count * part / inParts; };
  const opencl::Each all = [&](std::size_t n, const std::function<void(std::size_t)>& function) {
    each(n, function);
  };
  std::array<bool, kParts> started{};
  for (std::size_t k = 0; k < inParts; ++k) {
    try {
      parts[k].start(std::span(asked).subspan(begin(k), begin(k + 1) - begin(k)), all, report);
      started[k] = true;
    } catch (const std::bad_alloc&) {
    }
  }
  for (std::size_t k = 0; k < inParts; ++k) {
    if (!started[k]) continue;
    parts[k].finish(report);
    take(parts[k], begin(k), begin(k + 1) - begin(k));
  }
  for (std::size_t k = 0; k < inParts; ++k) {
    const std::size_t some = begin(k + 1) - begin(k);
    if (started[k]) continue;
    if (some == 1) {
      here.push_back(numbers[begin(k)]);
      ++report.noRoom;
      continue;
    }
    ask(begin(k), some / 2, 1);
    ask(begin(k) + some / 2, some - some / 2, 1);
  }
}

void ContactBatch::Inside::take(const opencl::OpenClBatch& part, std::size_t first,
                                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const CcAnswer& answer = part.answer(i);
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
    const CcAnswer& answer = part.answer(i);
    if (answer.failed) return;
    const opencl::Asked& one = asked[first + i];
    const std::size_t k = numbers[first + i];
    ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[k]);
    finder.finish(one.pair->a, one.pair->b, one.pair->settings, one.frame,
                  {answer.level, answer.hits, 0}, part.patches(i));
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
  for (const opencl::OpenClBatch& part : inside_->parts) sum += part.bytes();
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
