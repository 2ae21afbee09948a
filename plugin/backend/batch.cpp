// ContactBatch: which pairs go to the device, and what the CPU does for all.
#include <cloudcontact/batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
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
constexpr std::uint32_t kFirstRoom = 2048, kMostRoom = 1u << 20;

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
  std::unique_ptr<opencl::OpenClBatch> device;
  std::vector<opencl::Asked> asked;
  std::vector<std::size_t> numbers;  // of the pairs that are asked

  void onDevice(std::span<const BatchPair> pairs);
  void askDevice(std::span<const BatchPair> pairs, std::size_t first, std::size_t count);
  void take(std::span<const BatchPair> pairs, std::size_t first, std::size_t count);
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
    device = std::make_unique<opencl::OpenClBatch>(opencl::Device::open(settings.timing));
    name = device->device().name();
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

void ContactBatch::Inside::onDevice(std::span<const BatchPair> pairs) {
  asked.clear();
  numbers.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairFrame frame = ContactFinder::Scratch::of(finders[k]).begin(pairs[k].a, pairs[k].b);
    if (pairs[k].a.shape || pairs[k].b.shape) {
      here.push_back(k);
      ++report.shapes;
      continue;
    }
    asked.push_back({&pairs[k], frame, {rooms[k], rooms[k]}});
    numbers.push_back(k);
  }
  askDevice(pairs, 0, asked.size());
}

// A batch too large for the device is asked for in halves.
void ContactBatch::Inside::askDevice(std::span<const BatchPair> pairs, std::size_t first,
                                     std::size_t count) {
  if (count == 0) return;
  try {
    device->run(std::span(asked).subspan(first, count), report);
  } catch (const std::bad_alloc&) {
    if (count == 1) {
      here.push_back(numbers[first]);
      ++report.noRoom;
      return;
    }
    askDevice(pairs, first, count / 2);
    return askDevice(pairs, first + count / 2, count - count / 2);
  }
  take(pairs, first, count);
}

void ContactBatch::Inside::take(std::span<const BatchPair> pairs, std::size_t first,
                                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const CcAnswer& answer = device->answer(i);
    const std::size_t k = numbers[first + i];
    rooms[k] =
        std::clamp(answer.wanted + answer.wanted / 4, std::min(rooms[k], kMostRoom), kMostRoom);
    if (!answer.failed) continue;
    here.push_back(k);
    ++(answer.failed & CC_NO_TOUCH ? report.nearMisses : report.noRoom);
  }
  each(count, [&](std::size_t i) {
    const CcAnswer& answer = device->answer(i);
    if (answer.failed) return;
    const std::size_t k = numbers[first + i];
    const BatchPair& pair = pairs[k];
    ContactFinder::Scratch& finder = ContactFinder::Scratch::of(finders[k]);
    finder.finish(pair.a, pair.b, pair.settings, asked[first + i].frame,
                  {answer.level, answer.hits, 0}, device->patches(i));
    results[k] = &finder.named();
  });
  report.onDevice += count;
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
    s.report.onDevice -= s.here.size() - s.report.shapes;
    return s.results;
  }
#endif
  for (std::size_t k = 0; k < pairs.size(); ++k) s.here.push_back(k);
  s.onCpu(pairs);
  return s.results;
}

std::size_t ContactBatch::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  if (inside_->device) return inside_->device->bytes();
#endif
  return 0;
}

std::map<std::string, DeviceTime> ContactBatch::deviceTimes() {
  std::map<std::string, DeviceTime> times;
#if defined(CLOUDCONTACT_OPENCL)
  if (inside_->device)
    for (const auto& [name, spent] : inside_->device->device().clock())
      times[name] = {spent.seconds, spent.calls};
#endif
  return times;
}

}  // namespace cloudcontact
