// Runs a view between the steps of a world (live_view.h).
#include "view/live_view.h"

#include <cloudcontact/workpiece/cutter.h>

#include <algorithm>
#include <exception>
#include <map>

#include "replay/page.h"
#include "view/live_frames.h"
#include "view/pace.h"
#include "view/page_server.h"
#include "view/view_command.h"

namespace cloudcontact::program {
namespace {

using Clock = Pace::Clock;
using Millis = std::chrono::milliseconds;

constexpr auto kMoments = std::chrono::microseconds(16'666);  // between two, a screen's rate
constexpr auto kSurfaces = Millis(100);                       // between two looks at surfaces ...
constexpr int kShare = 4;                  // ... which take at most a fifth of the time
constexpr auto kLook = Millis(50);         // between questions whether the run goes on
constexpr std::size_t kLongestLine = 400;  // [bytes] for the reason of the end

std::string pageOf(LiveFrames& frames, const LiveViewSettings& settings) {
  Replay replay = frames.start();
  replay.title = settings.title;
  replay.setup = settings.setup;
  replay.voxel = settings.voxel;
  return pageBytes(replay);
}

// The first line, shortened, without its last full stop.
std::string lineOf(const std::string& text) {
  std::string line = text.substr(0, text.find('\n'));
  if (line.size() > kLongestLine) {
    std::size_t end = kLongestLine;
    while (end > 0 && (line[end] & 0xC0) == 0x80) --end;  // not within a character of UTF-8
    line = line.substr(0, end) + " ...";
  }
  if (line.ends_with('.') && !line.ends_with("...")) line.pop_back();
  return line;
}

}  // namespace

struct LiveView::State {
  State(World& w, double time, const LiveViewSettings& settings, std::unique_ptr<PageServer> s)
      : world(w), step(settings.step), frames(w, time), server(std::move(s)) {
    server->serve(pageOf(frames, settings), isPull);
    status.time = time;
    pace.set(settings.speed, time, Clock::now());
  }

  void obey(const PageMessage& message);
  void obey(int page, const ViewCommand& command);
  void pull(int page, const PullBody& pull);
  void cut(const CutBall& ball);
  void applyPulls();
  void run(bool on);
  void say(const std::string& words);
  bool isDue(Clock::time_point now);
  Clock::duration patience(Clock::time_point now);
  void show(Clock::time_point now);
  void showSurfaces(Clock::time_point now);

  World& world;
  double step;  // [s]
  LiveFrames frames;
  std::unique_ptr<PageServer> server;
  Pace pace;
  ViewStatus status;
  int single = 0;                 // steps that a paused run owes; a pause or a run forgets them
  std::map<int, BodyPull> pulls;  // of each page
  bool isChanged = true;          // since the last moment that was shown
  Clock::time_point shown, surfacesDue, asked;
};

void LiveView::State::obey(const PageMessage& message) {
  isChanged = true;
  if (message.isGone) {
    if (pulls.erase(message.page) > 0) applyPulls();
  } else if (const auto command = readCommand(message.text)) {
    obey(message.page, *command);
  } else {
    say("A page asked for what is not known here.");
  }
}

void LiveView::State::obey(int page, const ViewCommand& command) {
  struct Visitor {
    State& s;
    int page;
    void operator()(const RunOn&) { s.run(true); }
    void operator()(const Pause&) { s.run(false); }
    void operator()(const StepOnce&) {
      if (s.status.isRunning) s.run(false);
      ++s.single;
    }
    void operator()(const SetSpeed& speed) { s.pace.set(speed.times, s.status.time, Clock::now()); }
    void operator()(const PullBody& pull) { s.pull(page, pull); }
    void operator()(const Release&) {
      s.pulls.erase(page);
      s.applyPulls();
    }
    void operator()(const CutBall& ball) { s.cut(ball); }
  };
  std::visit(Visitor{*this, page}, command);
}

void LiveView::State::run(bool on) {
  single = 0;
  if (on && !status.isRunning) pace.set(pace.speed(), status.time, Clock::now());
  status.isRunning = on;
}

void LiveView::State::pull(int page, const PullBody& pull) {
  if (pull.body >= world.bodyCount()) return;
  if (!world.isPullable(pull.body))
    return say("'" + world.name(pull.body) + "' is static, driven or soft: it cannot be dragged.");
  BodyPull& mine = pulls[page] = world.pullOf(pull.body, pull.at, pull.to, step);
  mine.holder = this;
  applyPulls();
}

// A body that is gone leaves its pull. Those of other views of the world stay.
void LiveView::State::applyPulls() {
  std::vector<BodyPull> all = world.pulls();
  std::erase_if(all, [this](const BodyPull& pull) {
    return pull.holder == this || !world.isPullable(pull.body);
  });
  for (const auto& [page, pull] : pulls)
    if (world.isPullable(pull.body)) all.push_back(pull);
  world.setPulls(std::move(all));
}

void LiveView::State::cut(const CutBall& ball) {
  if (ball.body >= world.bodyCount()) return;
  if (!world.isCuttable(ball.body))
    return say("'" + world.name(ball.body) +
               "' cannot be cut: <cloudcontact:cuttable/> allows it.");
  if (world.cutOf(ball.body).gone) return;
  Pose place;
  place.position = world.matterPlace(ball.body).toLocal(ball.at);
  try {
    world.cut(ball.body, cutsOf(world.matter(ball.body), PlacedSolid{Sphere{ball.radius}}, place));
    applyPulls();
  } catch (const std::exception& why) {
    say("'" + world.name(ball.body) + "' is not cut: " + why.what());
  }
}

void LiveView::State::say(const std::string& words) {
  status.said = words;
  ++status.sayings;
}

bool LiveView::State::isDue(Clock::time_point now) {
  if (status.isRunning) return now >= pace.due(status.time, now);
  if (single == 0) return false;
  --single;
  return true;
}

Clock::duration LiveView::State::patience(Clock::time_point now) {
  if (!status.isRunning) return kLook;
  return std::clamp<Clock::duration>(pace.due(status.time, now) - now, Clock::duration::zero(),
                                     kLook);
}

void LiveView::State::show(Clock::time_point now) {
  const int pages = server->pages();
  isChanged = isChanged || pages != status.pages;
  status.pages = pages;
  if (pages == 0) return;
  if (now >= surfacesDue || frames.hasNewBodies()) showSurfaces(now);
  if (!isChanged || (now - shown < kMoments && !status.isEnded)) return;
  status.speed = pace.speed();
  status.factor = status.isRunning ? pace.reached(status.time, now) : 0;
  server->publish(LiveFrames::kMoment, frames.moment(status));
  status.steps = 0;
  shown = now;
  isChanged = false;
}

void LiveView::State::showSurfaces(Clock::time_point now) {
  for (auto& [topic, bytes] : frames.surfaces()) server->publish(topic, std::move(bytes));
  const Clock::time_point end = Clock::now();
  surfacesDue = end + std::max<Clock::duration>(kSurfaces, kShare * (end - now));
}

LiveView::LiveView(World& world, double time, const LiveViewSettings& settings,
                   std::unique_ptr<PageServer> server)
    : state_(std::make_unique<State>(world, time, settings, std::move(server))) {}

LiveView::~LiveView() {
  end();
}

void LiveView::end(const std::string& why) {
  State& s = *state_;
  if (s.status.isEnded) return;
  s.status.isRunning = false;
  s.status.isEnded = s.isChanged = true;
  s.surfacesDue = {};
  s.pulls.clear();
  try {
    s.status.why = lineOf(why);
    s.applyPulls();
    s.show(Clock::now());
  } catch (const std::exception&) {  // the pages then see the end alone
  }
}

const std::string& LiveView::url() const {
  return state_->server->url();
}

bool LiveView::follow(double time, const std::function<bool()>& goesOn) {
  State& s = *state_;
  if (time > s.status.time) ++s.status.steps;
  s.status.time = time;
  s.isChanged = true;
  Clock::duration patience{0};
  for (;;) {
    for (const PageMessage& message : s.server->messages(patience)) s.obey(message);
    const Clock::time_point now = Clock::now();
    s.show(now);
    if (now - s.asked >= kLook) {
      s.asked = now;
      if (!goesOn()) return false;
    }
    if (s.isDue(now)) return true;
    patience = s.patience(now);
  }
}

}  // namespace cloudcontact::program
