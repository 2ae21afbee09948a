// live_check [options of gtest]: a world that runs, in a browser: pauses it, steps it, drags a
// body, cuts one, with two pages open. The console must stay free of messages. Saves screenshots in
// the folder of CLOUDCONTACT_PICTURES, where it is set.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "program/browser.h"
#include "program/program_run.h"
#include "program/scene_bodies.h"
#include "replay/page.h"
#include "replay/recorder.h"
#include "scene/simulation.h"
#include "view/live_view.h"
#include "view/page_server.h"

namespace program_test {
namespace {

using namespace cloudcontact;
using namespace cloudcontact::program;

constexpr double kRunStep = 0.002;  // [s]

SceneDescription tableWith(std::vector<SceneBody> bodies) {
  bodies.insert(bodies.begin(), bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0));
  SceneDescription scene = sceneOf(std::move(bodies));
  scene.name = "a table";
  return scene;
}

// A world that runs in a thread of its own.
class LiveRun {
 public:
  LiveRun(const SceneDescription& scene, const WorldSettings& settings, double speed = 1)
      : world(scene, settings) {
    LiveViewSettings page;
    page.speed = speed;
    page.step = kRunStep;
    page.title = scene.name;
    page.setup = setupText(settings, kRunStep);
    page.voxel = settings.voxel;
    view = std::make_unique<LiveView>(world, 0, page, std::make_unique<PageServer>(0));
    url = view->url();
    thread_ = std::thread([this] {
      SimulationSettings run;
      run.seconds = 3600;
      run.step = kRunStep;
      run.instants = 1;
      run.goesOn = [this](double time) { return view->follow(time, [this] { return !ends_; }); };
      simulate(world, run);
      view.reset();
    });
  }
  ~LiveRun() { end(); }
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  World world;  // of the thread, until the end
  std::unique_ptr<LiveView> view;
  std::string url;

 private:
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

class LivePage : public Browser {
 public:
  explicit LivePage(const std::string& url, int width = 1280, int height = 800)
      : Browser(width, height) {
    openUrl(url);
    EXPECT_TRUE(becomes("document.documentElement.dataset.ready && window.cloudcontact"))
        << testing::PrintToString(complaints());
    EXPECT_TRUE(becomes("parseFloat(document.getElementById('clock').textContent) >= 0"));
  }
  double time() { return value("parseFloat(document.getElementById('clock').textContent)"); }
  Vec3 position(int body) {
    const auto p = value("cloudcontact.positions()[" + std::to_string(body) + "]");
    return Vec3(double(p[0]), double(p[1]), double(p[2]));
  }
  Eigen::Vector2d inWindow(int body) {
    const auto p = value("cloudcontact.inWindow(" + std::to_string(body) + ")");
    return Eigen::Vector2d(double(p[0]), double(p[1]));
  }
  bool runs() {
    return value("document.getElementById('play').getAttribute('aria-pressed')") == "true";
  }
  // Pairs of things that are seen one on the other, which none should be.
  nlohmann::json onEachOther() {
    return value(R"((() => {
      const all = [...document.querySelectorAll(
        '#toolbar > *, #cutting, #carving, #hint, #legend, #play, #step, #pace, #clock, #speed')]
        .map(e => [e.id, e.getBoundingClientRect()]).filter(([, r]) => r.width > 0);
      const meet = (p, q) =>
        p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom;
      return all.flatMap(([a, p]) =>
        all.filter(([b, q]) => a < b && meet(p, q)).map(([b]) => a + ' ' + b));
    })())");
  }
  void keep(const std::string& name) {
    const std::string png = screenshot();
    if (const char* folder = std::getenv("CLOUDCONTACT_PICTURES"))
      std::ofstream(std::filesystem::path(folder) / (name + ".png"), std::ios::binary) << png;
  }
};

const SceneBox kBrick{Vec3(0.04, 0.03, 0.02)};

SceneDescription brick(double height) {
  return tableWith({bodyWith("brick", kBrick, Vec3(0, 0, height), 0.2)});
}

TEST(Live, ShowsAWorldThatRunsPausesAndSteps) {
  LiveRun run(brick(0.06), voxels(0.002));
  LivePage page(run.url);
  EXPECT_TRUE(page.becomes("cloudcontact.positions()[1][2] < 0.015"));
  EXPECT_TRUE(page.becomes("parseFloat(document.getElementById('clock').textContent) > 1"));
  EXPECT_TRUE(page.becomes("parseInt(document.getElementById('contact-words').textContent) >= 3"));
  page.keep("live-rest");
  page.press(" ");
  EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent === 'paused'"));
  EXPECT_FALSE(page.runs());
  const double stopped = page.time();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(page.time(), stopped);
  page.press("ArrowRight");
  EXPECT_TRUE(page.becomes("parseFloat(document.getElementById('clock').textContent) > " +
                           std::to_string(stopped)));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_NEAR(page.time(), stopped + kRunStep, 1e-6);
  page.press(" ");
  EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent !== 'paused'"));
  run.end();
  EXPECT_TRUE(page.becomes("document.getElementById('hint').textContent.includes('has ended')"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));  // text is renewed each second
  page.keep("live-end");
  EXPECT_EQ(page.value("document.getElementById('pace').textContent"), "ended");
  EXPECT_EQ(page.value("document.getElementById('live-words').textContent"),
            "The simulation has ended.");
  EXPECT_LT(double(page.value("Number(getComputedStyle(document.getElementById('play')).opacity)")),
            1);
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

TEST(Live, AnySpeedIsShownAndTheKeysLeadBackToTheList) {
  LiveRun run(brick(0.0101), voxels(0.002), 0.3);
  LivePage page(run.url);
  const auto shows = [&](const std::string& speed) {
    return page.becomes("document.getElementById('speed').value === '" + speed + "'");
  };
  EXPECT_TRUE(shows("0.3"));
  page.press("ArrowUp");
  EXPECT_TRUE(shows("0.5"));
  page.press("ArrowDown");
  EXPECT_TRUE(shows("0.25"));
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

// Beside a tall post, so that the view shows room enough for the brick to hang free: lower, it
// leans with an edge on the table and stays so.
TEST(Live, ABodyIsDraggedAndFallsBack) {
  LiveRun run(
      tableWith({bodyWith("brick", kBrick, Vec3(0, 0, 0.0101), 0.2),
                 bodyWith("post", SceneBox{Vec3(0.01, 0.01, 0.12)}, Vec3(-0.06, 0, 0.06), 0)}),
      voxels(0.002));
  LivePage page(run.url);
  const Vec3 before = page.position(1);
  const Eigen::Vector2d from = page.inWindow(1), to = from + Eigen::Vector2d(60, -160);
  page.grab(from.x(), from.y());
  page.move(from.x(), from.y(), to.x(), to.y());
  EXPECT_TRUE(page.becomes("cloudcontact.positions()[1][2] > 0.025"));
  // It comes to the pointer and hangs there, its center below the place where it is held.
  const auto distance = [&] { return (page.inWindow(1) - to).norm(); };
  for (int i = 0; i < 500 && distance() > 90; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LT(distance(), 90);
  EXPECT_GT((page.position(1) - before).norm(), 0.01);
  const std::string words = page.value("document.getElementById('pull-words').textContent");
  EXPECT_NE(words.find("N/m"), std::string::npos) << words;
  page.keep("live-drag");
  page.letGo(to.x(), to.y());
  EXPECT_TRUE(page.becomes("cloudcontact.positions()[1][2] < 0.0215"));
  EXPECT_TRUE(page.becomes("document.getElementById('pull-words').textContent === ''"));
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

// The words beside the name in the n-th line of the list of bodies.
std::string massOf(int n) {
  return "document.querySelector('#bodies li:nth-child(" + std::to_string(n) +
         ") small').textContent";
}

// Beside the longest name its mass is seen; a driven body has none.
TEST(Live, TheListOfBodiesSaysWhatTheyWeigh) {
  SceneBody belt = bodyWith("belt", kBrick, Vec3(0.1, 0, 0.02), 0);
  belt.isStatic = false;
  belt.drive = SceneDrive{};
  const std::string name(60, 'n');
  LiveRun run(tableWith({bodyWith(name, kBrick, Vec3(0, 0, 0.0101), 0.2), belt}), voxels(0.002));
  LivePage page(run.url);
  EXPECT_TRUE(page.becomes(massOf(2) + " === '200 g'"));
  EXPECT_EQ(page.value(massOf(1)), "fixed");
  EXPECT_EQ(page.value(massOf(3)), "driven");
  EXPECT_EQ(page.value("(li => li.querySelector('small').getBoundingClientRect().right < "
                       "li.querySelector('button').getBoundingClientRect().left)"
                       "(document.querySelector('#bodies li:nth-child(2)'))"),
            true);
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

// The view turns instead, which says nothing of the body.
TEST(Live, AGrabThatDragsNothingSaysWhy) {
  SceneBody wall = bodyWith("wall", kBrick, Vec3(0, 0, 0.02), 0);
  SceneBody belt = bodyWith("belt", kBrick, Vec3(0.1, 0, 0.02), 0);
  belt.isStatic = false;
  belt.drive = SceneDrive{};
  LiveRun run(tableWith({wall, belt}), voxels(0.002));
  LivePage page(run.url);
  const char* const kinds[] = {"fixed", "driven"};
  for (const int body : {1, 2}) {
    const Eigen::Vector2d at = page.inWindow(body);
    page.click(at.x(), at.y());
    EXPECT_EQ(page.value("document.getElementById('hint').hidden"), false);
    const std::string words = page.value("document.getElementById('hint').textContent");
    EXPECT_NE(words.find(kinds[body - 1]), std::string::npos) << words;
  }
  page.press("k");  // nothing can be cut, so there is no such mode
  EXPECT_EQ(page.value("document.getElementById('carving').hidden"), true);
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

// A slab that is carved through falls in two.
TEST(Live, TheHandCutsWhatIsCuttable) {
  SceneBody slab = bodyWith("slab", SceneBox{Vec3(0.04, 0.012, 0.012)}, Vec3(0, 0, 0.0065), 0);
  slab.isStatic = false;
  slab.collisions[0].isCuttable = true;
  WorldSettings settings = voxels(0.001);
  settings.common.tissues.made = {{"gum", 500, 1, 1e5, 1000}};
  slab.collisions[0].tissues = {{"", "gum"}};
  LiveRun run(tableWith({slab}), settings);
  const double whole = run.world.mass(1);
  LivePage page(run.url);
  EXPECT_NEAR(double(page.value("parseFloat(" + massOf(2) + ")")), 1e3 * whole, 10 * whole);
  page.press(" ");
  EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent === 'paused'"));
  page.press("k");
  EXPECT_EQ(page.value("document.getElementById('carving').hidden"), false);
  page.value("document.getElementById('carve-radius').value = 0.2");
  const Eigen::Vector2d at = page.inWindow(1);
  const std::string before = page.screenshot();
  // Strokes across it, each deeper than the last.
  const auto isInTwo = [&] {
    return page.value("document.querySelectorAll('#bodies li').length > 2") == true;
  };
  for (int stroke = 0; stroke < 20 && !isInTwo(); ++stroke) {
    page.grab(at.x(), at.y() - 60);
    for (int y = -60; y < 100; y += 20) {
      page.move(at.x(), at.y() + y, at.x(), at.y() + y + 20);
      page.screenshot();  // waits for two pictures
    }
    page.letGo(at.x(), at.y() + 100);
  }
  EXPECT_TRUE(isInTwo());
  page.press("k");
  EXPECT_TRUE(page.becomes(massOf(2) + " !== '' && parseFloat(" + massOf(2) + ") < " +
                           std::to_string(1e3 * whole)));
  page.keep("live-cut");
  EXPECT_GT(difference(before, page.screenshot()), 0.002);
  page.press(" ");  // both parts move on
  EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent !== 'paused'"));
  run.end();
  EXPECT_GE(run.world.bodyCount(), 3u);
  EXPECT_GT(run.world.cutOf(1).volume, 0);
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

// Both bars, a message and the legend, in both sizes; a pause moves nothing.
TEST(Live, NothingLiesOnAnythingElse) {
  SceneBody block = bodyWith("block", kBrick, Vec3(0, 0, 0.0101), 0.2);
  block.collisions[0].isCuttable = true;
  WorldSettings settings = voxels(0.002);
  settings.common.tissues.made = {{"gum", 500, 1, 1e5, 1000}};
  block.collisions[0].tissues = {{"", "gum"}};
  LiveRun run(tableWith({block}), settings);
  for (const int width : {1280, 360}) {
    LivePage page(run.url, width, 740);
    EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent.includes('real')"));
    page.press("x");
    page.press("k");
    page.value(
        "(e => { e.textContent = 'A long message that tells why a body cannot be cut, and what "
        "allows it.'; e.hidden = false; })(document.getElementById('hint'))");
    page.keep("live-bars-" + std::to_string(width));
    EXPECT_EQ(page.onEachOther(), nlohmann::json::array()) << width;
    const auto high = page.value("document.getElementById('view').clientHeight");
    page.press(" ");
    EXPECT_TRUE(page.becomes("document.getElementById('pace').textContent === 'paused'"));
    EXPECT_EQ(page.value("document.getElementById('view').clientHeight"), high);
    page.press(" ");
    EXPECT_EQ(page.complaints(), std::vector<std::string>());
  }
}

TEST(Live, TwoPagesShowOneRun) {
  LiveRun run(brick(0.03), voxels(0.002));
  LivePage one(run.url);
  {
    LivePage two(run.url);
    two.press(" ");
    for (LivePage* page : {&one, &two})
      EXPECT_TRUE(page->becomes("document.getElementById('pace').textContent === 'paused'"));
    EXPECT_EQ(one.time(), two.time());
  }  // one page is closed; the other goes on
  one.press(" ");
  EXPECT_TRUE(one.becomes("document.getElementById('pace').textContent !== 'paused'"));
  EXPECT_EQ(one.complaints(), std::vector<std::string>());
}

// As the Python package shows a replay in a notebook.
TEST(Live, AReplayIsDrawnInASandboxedFrame) {
  World world(brick(0.03), voxels(0.002));
  Recorder recorder;
  SimulationSettings run;
  run.seconds = 0.1;
  run.step = kRunStep;
  recorder.begin(world, "", run.seconds, run.step);
  run.observe = [&](double time, const World& now) { recorder.record(time, now); };
  simulate(world, run);
  std::string page;
  for (const char c : pageBytes(recorder.finish()))
    page += c == '&' ? std::string("&amp;") : c == '"' ? std::string("&quot;") : std::string(1, c);
  const Workplace place;
  place.write("notebook.html", "<!doctype html><iframe sandbox=\"allow-scripts\" srcdoc=\"" + page +
                                   "\" style=\"width: 100%; height: 640px\"></iframe>");
  Browser browser(1280, 800);
  browser.open(place / "notebook.html");
  // Nothing in the frame can be asked from outside. A page without its bodies has about 200 colors.
  std::size_t seen = 0;
  for (int i = 0; i < 200 && seen < 500; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    seen = colors(browser.screenshot());
  }
  EXPECT_GT(seen, 500u);
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
}

// How fast depends on the machine: the figures are for people.
TEST(Live, AHundredBodies) {
  std::vector<SceneBody> bricks;
  for (int i = 0; i < 100; ++i)
    bricks.push_back(bodyWith("brick " + std::to_string(i), kBrick,
                              Vec3(0.06 * (i % 10), 0.05 * (i / 10 % 5), 0.02 + 0.035 * (i / 50)),
                              0.05));
  WorldSettings settings = voxels(0.005);
  settings.common.reuse = 0.02;
  LiveRun run(tableWith(bricks), settings);
  LivePage page(run.url);
  EXPECT_TRUE(page.becomes("cloudcontact.positions()[100][2] < 0.05"));
  std::this_thread::sleep_for(std::chrono::seconds(8));  // for the page to find its pace
  std::cout << "a hundred bodies: "
            << page.value("document.getElementById('live-words').textContent") << ' '
            << page.value("document.getElementById('pace').textContent") << '\n';
  page.keep("live-hundred");
  EXPECT_EQ(page.complaints(), std::vector<std::string>());
}

}  // namespace
}  // namespace program_test
