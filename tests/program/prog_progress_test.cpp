// The progress bar: drawn with the time left on a terminal, absent in a pipe, one for two pieces of
// work at the same time.
#include <gtest/gtest.h>
#include <pty.h>

#include <chrono>
#include <functional>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "io/both.h"
#include "io/errors.h"
#include "io/progress.h"
#include "program/program_run.h"

namespace cloudcontact::program::prog_progress_test {
namespace {

// The program's stderr output on a terminal of this width.
std::string onTerminal(const program_test::Workplace& place, unsigned short columns,
                       std::vector<std::string> words) {
  winsize size{24, columns, 0, 0};
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
  if (child < 0) return "";
  if (child == 0) {
    if (chdir((place / "").c_str()) != 0) _exit(126);
    const int quiet = open("/dev/null", O_WRONLY);
    dup2(quiet, STDOUT_FILENO);
    std::vector<char*> raw = {const_cast<char*>("cloudcontact")};
    for (const std::string& word : words) raw.push_back(const_cast<char*>(word.c_str()));
    raw.push_back(nullptr);
    execv(CLOUDCONTACT_EXECUTABLE, raw.data());
    _exit(127);
  }
  std::string seen;
  char bytes[4096];
  for (ssize_t count; (count = read(terminal, bytes, sizeof bytes)) > 0;)
    seen.append(bytes, static_cast<std::size_t>(count));
  waitpid(child, nullptr, 0);
  close(terminal);
  return seen;
}

TEST(Progress, ShowsTheTimeLeft) {
  EXPECT_EQ(timeLeftText(0.2), "1 s left");
  EXPECT_EQ(timeLeftText(59), "59 s left");
  EXPECT_EQ(timeLeftText(61), "2 min left");
  EXPECT_EQ(timeLeftText(3 * 3600 + 61), "3 h 1 min left");
}

TEST(Progress, OfAPairIsTheMeanAndEndsOnce) {
  std::vector<double> drawn;
  {
    const PairProgress pair(
        [&](const std::string&) { return [&](double done) { drawn.push_back(done); }; }, "both");
    pair.of(0)(0.5);
    pair.of(1)(0.25);
    pair.of(0)(1);
    pair.of(1)(1);
    EXPECT_EQ(drawn, (std::vector<double>{0.25, 0.375, 0.625}));
  }
  EXPECT_EQ(drawn.back(), 1);
  const PairProgress silent([](const std::string&) { return std::function<void(double)>(); }, "");
  EXPECT_FALSE(silent.of(0));
}

TEST(Both, RunAtTheSameTimeUnlessThreadsAreCounted) {
  const std::thread::id here = std::this_thread::get_id();
  for (const int threads : {1, 2}) {
    const auto [a, b] = bothOf(threads, std::this_thread::get_id, std::this_thread::get_id);
    EXPECT_EQ(a, here);
    EXPECT_EQ(b, here);
  }
  std::promise<int> ofA, ofB;  // each waits for the other
  const auto meet = [](std::promise<int>& own, std::promise<int>& other, int value) {
    own.set_value(value);
    std::future<int> found = other.get_future();
    return found.wait_for(std::chrono::minutes(1)) == std::future_status::ready ? found.get() : -1;
  };
  const auto [a, b] = bothOf(
      0, [&] { return meet(ofA, ofB, 3); }, [&] { return meet(ofB, ofA, 4); });
  EXPECT_EQ(a, 4);
  EXPECT_EQ(b, 3);
}

TEST(Both, FailAsInTurn) {
  const auto fail = [](const char* what) { return [what]() -> int { throw BadInput(what); }; };
  for (const int threads : {0, 1}) {
    for (const bool second : {false, true}) {
      try {
        bothOf(threads, fail("a"), [&] { return second ? fail("b")() : 1; });
        ADD_FAILURE() << "nothing thrown";
      } catch (const BadInput& error) {
        EXPECT_STREQ(error.what(), "a");
      }
    }
    EXPECT_THROW(bothOf(
                     threads, [] { return 1; }, fail("b")),
                 BadInput);
  }
}

TEST(Progress, IsDrawnOnATerminalAndWiped) {
  if (access("/dev/pts/ptmx", F_OK) != 0) GTEST_SKIP() << "this machine has no terminals";
  const program_test::Workplace place;
  for (const unsigned short columns : {80, 60}) {
    const std::string seen =
        onTerminal(place, columns, {"digitize", "sphere:0.1", "--voxel", "0.0007"});
    EXPECT_NE(seen.find(" %"), std::string::npos) << seen;
    EXPECT_NE(seen.find("#--"), std::string::npos) << seen;
    EXPECT_NE(seen.find(" left"), std::string::npos) << seen;
    // Each drawing restarts the line and fits into it; the last one clears it.
    std::size_t at = 0;
    while ((at = seen.find("\r\033[K", at)) != std::string::npos) {
      const std::size_t next = std::min(seen.find('\r', at + 1), seen.size());
      EXPECT_LE(next - at - 4, columns);
      at = next;
    }
    EXPECT_EQ(seen.substr(seen.size() - 4), "\r\033[K");
  }
}

TEST(Progress, IsSilentInAPipe) {
  const program_test::Workplace place;
  const auto outcome = place.run({"digitize", "sphere:0.1", "--voxel", "0.0007"});
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_EQ(outcome.err, "");
}

}  // namespace
}  // namespace cloudcontact::program::prog_progress_test
