// The program cloudcontact-work: counts what scenes and pairs take, and compares it with the counts
// of the last commit (benchmarks/work.json) or writes these, for script/test; or times the same
// list, for script/bench --guard.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>

#include "commands/command_line.h"
#include "io/errors.h"
#include "io/output_file.h"
#include "lab/work_file.h"

namespace cloudcontact::program {
namespace {

struct WorkOptions {
  std::string file, only, times;
  std::string checkout = CLOUDCONTACT_SOURCE_DIR;
  int threads = 1;
  bool update = false, gimpact = false;

  bool wants(const lab::WorkSource& source) const {
    return source.name.find(only) != std::string::npos;
  }
};

Json read(const std::string& file, bool update) {
  std::ifstream in(file);
  if (!in && update) return Json::object();
  if (!in) throw BadInput(file + ": cannot be read; --update makes it");
  return Json::parse(in);
}

void count(const WorkOptions& options) {
  const Json before = read(options.file, options.update);
  std::vector<lab::WorkEntry> now;
  for (const lab::WorkSource& source : lab::workSources(options.checkout, options.threads))
    if (options.wants(source))
      for (lab::WorkEntry& entry : source.count()) now.push_back(std::move(entry));
  const lab::WorkChanges changes = lab::compared(before, now);
  for (const std::string& line : changes.faults) std::cout << "more work: " << line << '\n';
  for (const std::string& line : changes.news) std::cout << "good news: " << line << '\n';
  std::cout << now.size() << " scenes and pairs counted" << std::endl;
  if (options.update) return writeWhole("FILE", options.file, lab::workText(before, now));
  const std::string how = "script/bench --counts updates the file";
  if (!changes.news.empty()) std::cout << "good news: " << how << std::endl;
  if (!changes.faults.empty())
    throw WorkFailed(options.file + ": counts grew by more than 3 %. If a commit means it: " + how +
                     ", and the commit says why");
}

void time(const WorkOptions& options) {
  std::vector<lab::WorkTime> times;
  for (const lab::WorkSource& source : lab::workSources(options.checkout, 1))
    if (options.wants(source))
      for (lab::WorkTime& each : source.time(options.gimpact)) times.push_back(std::move(each));
  writeWhole("--times", options.times, jsonText(lab::timesJson(times), 1) + '\n');
}

void addOptions(CLI::App& command) {
  const auto options = std::make_shared<WorkOptions>();
  WorkOptions& o = *options;
  command.add_option("file", o.file, "the counts to compare with")->option_text("WORK.json");
  command.add_option("--checkout", o.checkout, "of the project, with the scenes")->type_name("DIR");
  command.add_option("--only", o.only, "a part of the names of what is measured");
  command.add_option("--threads", o.threads, "of the worlds; the counts are the same")
      ->check(CLI::Range(1, 1024));
  command.add_flag("--update", o.update, "writes the counts to WORK.json");
  command.add_option("--times", o.times, "times instead of counts, to this file")
      ->type_name("TIMES.json");
  command.add_flag("--gimpact", o.gimpact, "with --times: the same bodies as GImpact meshes, too");
  command.callback([options] {
    if (options->file.empty() == options->times.empty())
      throw BadInput("cloudcontact-work: give WORK.json or --times");
    return options->times.empty() ? count(*options) : time(*options);
  });
}

}  // namespace
}  // namespace cloudcontact::program

int main(int argc, char** argv) {
  CLI::App app("Counts what contacts take, in numbers that no machine changes.",
               "cloudcontact-work");
  return cloudcontact::program::runCommandLine(argc, argv, app, cloudcontact::program::addOptions);
}
