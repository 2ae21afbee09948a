// Runs the built program with arguments and returns its exit code and both output streams.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace program_test {

struct Outcome {
  int exitCode = -1;
  std::string out, err;

  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

// A temporary folder for one test, in which the program runs.
class Workplace {
 public:
  Workplace() {
    std::string name = (std::filesystem::temp_directory_path() / "cloudcontact.XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~Workplace() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_))
      names.insert(entry.path().lexically_relative(folder_).string());
    return names;
  }

  // The streams go to files in another folder, so that files() lists the program's only. The user's
  // cache is left alone, unless CLOUDCONTACT_CACHE is set.
  Outcome run(const std::vector<std::string>& arguments) const {
    const std::string streams = folder_.string() + ".streams";
    std::filesystem::create_directory(streams);
    const pid_t child = fork();
    if (child == 0) {
      setenv("CLOUDCONTACT_CACHE", "off", 0);
      // Uses descriptors, not stdio, so that the child does not print the test's buffered output.
      if (chdir(folder_.c_str()) != 0 || !redirect(STDOUT_FILENO, streams + "/out") ||
          !redirect(STDERR_FILENO, streams + "/err"))
        _exit(126);
      std::vector<char*> raw = {const_cast<char*>("cloudcontact")};
      for (const std::string& a : arguments) raw.push_back(const_cast<char*>(a.c_str()));
      raw.push_back(nullptr);
      execv(CLOUDCONTACT_EXECUTABLE, raw.data());
      _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    Outcome outcome;
    outcome.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    outcome.out = slurp(streams + "/out");
    outcome.err = slurp(streams + "/err");
    std::filesystem::remove_all(streams);
    return outcome;
  }

 private:
  static bool redirect(int stream, const std::string& file) {
    const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    return opened >= 0 && dup2(opened, stream) >= 0 && close(opened) == 0;
  }
  static std::string slurp(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  std::filesystem::path folder_;
};

}  // namespace program_test
