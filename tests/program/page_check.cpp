// page_check FILE.html [options of gtest]: opens a replay's page in a browser, in a desktop and a
// phone size, and uses it: plays, scrubs, toggles, cuts. Saves screenshots next to the file. The
// console must stay free of messages.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "program/browser.h"

namespace program_test {
namespace {

std::string page;                              // the file, from the command line
constexpr std::size_t kColorsOfLetters = 500;  // a blank page has about 200

struct Size {
  int width, height;
};

class PageAt : public testing::TestWithParam<Size> {
 protected:
  PageAt() : browser(GetParam().width, GetParam().height) {
    browser.open(page);
    ready = browser.becomes("document.documentElement.dataset.ready");
  }
  double time() { return browser.value("Number(document.getElementById('scrub').value)"); }
  double seconds() { return browser.value("Number(document.getElementById('scrub').max)"); }
  void clickOn(const std::string& selector, double share = 0.5) {
    const auto box = browser.value("(b => [b.x, b.y, b.width, b.height])(document.querySelector('" +
                                   selector + "').getBoundingClientRect())");
    browser.click(double(box[0]) + share * double(box[2]), double(box[1]) + double(box[3]) / 2);
  }
  bool pressed(const std::string& id) {
    return browser.value("document.getElementById('" + id + "').getAttribute('aria-pressed')") ==
           "true";
  }
  // A click on a button changes the picture, and a second click reverts it.
  void expectToggles(const std::string& id, double least) {
    const std::string before = browser.screenshot();
    const bool was = pressed(id);
    clickOn("#" + id);
    EXPECT_NE(pressed(id), was) << id;
    const std::string after = browser.screenshot();
    keep(after, id);
    EXPECT_GT(difference(before, after), least) << id;
    clickOn("#" + id);
    EXPECT_EQ(pressed(id), was) << id;
    EXPECT_LT(difference(before, browser.screenshot()), least) << id;
  }
  // At the ends of its range the cut leaves all of the bodies, or none.
  void expectCutsAway() {
    clickOn("#contacts");
    clickOn("#cut");
    const auto cutAt = [&](const char* end) {
      browser.value(
          std::string("(slider => { slider.value = slider.") + end +
          "; slider.dispatchEvent(new Event('input')); })(document.getElementById('cut-at'))");
      return browser.screenshot();
    };
    const auto showGraphs = [&](const char* how) {
      browser.value(std::string("document.getElementById('graphs').style.visibility = '") + how +
                    "'");
    };
    showGraphs("hidden");                                       // they have colors of their own
    const std::string none = cutAt("max"), all = cutAt("min");  // keeps the part behind
    // A hanging chain covers a hundredth of the picture.
    EXPECT_GT(difference(all, none), 0.004);
    EXPECT_GT(double(colors(all)), 1.1 * double(colors(none)));
    clickOn("#cut-flip");
    EXPECT_GT(difference(all, browser.screenshot()), 0.004);  // keeps the other half
    clickOn("#cut-flip");
    clickOn("#cut");
    clickOn("#contacts");
    showGraphs("visible");
  }
  void keep(const std::string& png, const std::string& what) {
    const std::filesystem::path file(page);
    std::ofstream(file.parent_path() / (file.stem().string() + "-" +
                                        std::to_string(GetParam().width) + "-" + what + ".png"),
                  std::ios::binary)
        << png;
  }

  Browser browser;
  bool ready = false;
};

TEST_P(PageAt, ShowsPlaysScrubsTogglesAndCuts) {
  ASSERT_TRUE(ready) << testing::PrintToString(browser.complaints());
  std::cout << page << " open after "
            << browser.value("document.documentElement.dataset.ready").get<std::string>()
            << " ms\n";
  const std::string start = browser.screenshot();
  EXPECT_GT(colors(start), kColorsOfLetters);
  EXPECT_EQ(time(), 0);

  clickOn("#play");
  EXPECT_TRUE(browser.becomes("document.getElementById('scrub').value > 0"));
  clickOn("#play");
  EXPECT_FALSE(pressed("play"));
  const double stopped = time();
  EXPECT_GT(stopped, 0);

  clickOn("#scrub", 0.6);
  EXPECT_NEAR(time() / seconds(), 0.6, 0.05);
  clickOn("#graphs canvas", 0.5);
  EXPECT_NEAR(time() / seconds(), 0.5, 0.02);
  keep(browser.screenshot(), "middle");
  browser.press("Home");
  EXPECT_EQ(time(), 0);
  EXPECT_LT(difference(start, browser.screenshot()), 0.002);
  browser.press("ArrowRight");
  EXPECT_GT(time(), 0);
  browser.press("End");
  EXPECT_NEAR(time(), seconds(), 1e-3 * seconds());

  expectToggles("contacts", 0.001);
  expectToggles("cut", 0.003);
  expectToggles("fade", 0.003);
  expectToggles("voxels", 0.0005);
  expectCutsAway();
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
}

// What the first tier asks of every page.
TEST_P(PageAt, OpensAndFitsItsWindow) {
  ASSERT_TRUE(ready) << testing::PrintToString(browser.complaints());
  EXPECT_GT(colors(browser.screenshot()), kColorsOfLetters);
  EXPECT_EQ(browser.value("document.documentElement.scrollWidth <= innerWidth"), true);
  EXPECT_EQ(browser.value("document.documentElement.scrollHeight <= innerHeight"), true);
  const auto outside = browser.value(
      "[...document.querySelectorAll('button, input, select')].filter(e => {"
      " const b = e.getBoundingClientRect(), p = e.closest('#panel');"
      " return !p && b.width > 0 && (b.left < 0 || b.right > innerWidth + 0.5 || b.top < 0 || "
      "b.bottom > innerHeight + 0.5); }).map(e => e.id)");
  EXPECT_EQ(outside, nlohmann::json::array());
  EXPECT_GT(double(browser.value("document.getElementById('view').clientHeight")), 250);
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
}

TEST_P(PageAt, TurnsUnderThePointer) {
  ASSERT_TRUE(ready);
  const double x = browser.value("document.getElementById('view').clientWidth / 2");
  browser.click(x, 300);
  browser.press("r");  // sets the focus, whose ring shows, as later on
  const std::string before = browser.screenshot();
  browser.drag(x, 300, x + 120, 260);
  EXPECT_GT(difference(before, browser.screenshot()), 0.005);
  browser.press("r");
  EXPECT_LT(difference(before, browser.screenshot()), 0.002);
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
}

INSTANTIATE_TEST_SUITE_P(Sizes, PageAt, testing::Values(Size{1280, 800}, Size{400, 800}),
                         [](const auto& size) { return "w" + std::to_string(size.param.width); });

TEST(Page, SaysWhatToDoWithoutWebGl) {
  Browser browser(1280, 800, {"--disable-3d-apis"});
  browser.open(page);
  ASSERT_TRUE(browser.becomes("document.documentElement.dataset.ready"));
  const std::string words = browser.value("document.getElementById('message').innerText");
  EXPECT_NE(words.find("WebGL"), std::string::npos);
  EXPECT_EQ(browser.value("document.getElementById('message').offsetHeight > 100"), true);
  EXPECT_EQ(browser.value("[...document.querySelectorAll('.drawn')].every(e => e.hidden)"), true);
  browser.press("End");  // the graphs are present nevertheless
  EXPECT_EQ(browser.value("document.querySelectorAll('#graphs canvas').length"), 3);
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
}

// As after a connection that broke, or a full disk.
TEST(Page, SaysThatItsEndIsMissing) {
  std::ifstream whole(page, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(whole)), {});
  const std::string file = page + ".part.html";
  std::ofstream(file, std::ios::binary) << text.substr(0, text.size() / 2);
  Browser browser(400, 800);
  browser.open(file);
  EXPECT_TRUE(
      browser.becomes("(e => e.offsetHeight > 100 && e.innerText.includes('incomplete'))"
                      "(document.getElementById('message'))",
                      10));
  EXPECT_EQ(browser.complaints(), std::vector<std::string>());
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace program_test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc != 2 || !std::filesystem::exists(argv[1])) {
    std::cerr << "page_check: needs a replay's page\n";
    return 2;
  }
  program_test::page = argv[1];
  return RUN_ALL_TESTS();
}
