// The fuzz program without libFuzzer: a fixed number of mutated seeds, the same in each run, or the
// inputs in files.
//   cloudcontact_fuzz --target=NAME --runs=N
//   cloudcontact_fuzz --target=NAME FILE...
// Where a run ends the program, its input is left in the file fuzz-NAME.input.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "fuzz/fuzz_choice.h"
#include "fuzz/fuzz_input.h"

namespace cloudcontact::fuzz {
namespace {

std::string current, leftBehind;

void keepInput(int signal) {
  const int file = open(leftBehind.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
  if (file >= 0 && write(file, current.data(), current.size()) >= 0) close(file);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

class Mutations {
 public:
  // A seed after up to eight changes.
  std::string of(const std::vector<std::string>& seeds, std::size_t longest) {
    std::string text = seeds[below(seeds.size())];
    for (std::size_t left = below(9); left > 0; --left) change(text);
    text.resize(std::min(text.size(), longest));
    return text;
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }
  void change(std::string& text) {
    constexpr std::uint64_t kEdges[] = {0,
                                        1,
                                        0x7f,
                                        0x80,
                                        0xff,
                                        0x7fff,
                                        0x7fffffff,
                                        0x80000000,
                                        0xffffffff,
                                        0x7ff0000000000000,
                                        0x7ff8000000000000,
                                        0xffffffffffffffff,
                                        1000000000000};
    const std::size_t at = below(text.size());
    switch (below(6)) {
      case 0:
        if (!text.empty()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        return;
      case 1:
        if (!text.empty()) text[at] = static_cast<char>(below(256));
        return;
      case 2:
        text.erase(at, 1 + below(16));
        return;
      case 3:
        text.insert(at, text.substr(below(text.size()), 1 + below(32)));
        return;
      case 4:
        text.resize(at);
        return;
      default: {
        const std::uint64_t edge = kEdges[below(std::size(kEdges))];
        const std::size_t size = std::size_t{1} << below(4);
        if (at + size <= text.size()) std::memcpy(text.data() + at, &edge, size);
      }
    }
  }
  std::mt19937_64 random_{20};
};

int runAll(const Target& target, int argc, char** argv) {
  int done = 0;
  const auto run = [&](std::string input) {
    current = std::move(input);
    target.run(current);
    ++done;
  };
  for (int i = 2; i < argc; ++i)
    if (argv[i][0] != '-') run(contentOf(argv[i]));
  const std::vector<std::string> seeds = target.seeds();
  for (const std::string& seed : seeds) run(seed);
  Mutations mutations;
  for (int left = std::atoi(argumentOf("runs", argc, argv).c_str()); left > 0; --left)
    run(mutations.of(seeds, target.longest));
  std::printf("%s: %d inputs\n", target.name, done);
  return 0;
}

}  // namespace
}  // namespace cloudcontact::fuzz

int main(int argc, char** argv) {
  using namespace cloudcontact::fuzz;
  const Target target = chosenTarget(argc, argv);
  leftBehind = "fuzz-" + std::string(target.name) + ".input";
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS}) std::signal(signal, keepInput);
  return runAll(target, argc, argv);
}
