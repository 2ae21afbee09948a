// Runs trials in parallel, and those that are timed one by one. Each has a world of its own, so
// their order does not matter.
#include "lab/stability.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

namespace cloudcontact::program::lab {

Verdict atMost(double figure, double limit, const std::string& otherwise) {
  const bool holds = figure <= limit;  // false for NaN
  return {holds ? Outcome::Holds : Outcome::Fails, figure, limit, holds ? "" : otherwise};
}

Verdict within(double figure, double expected, double share, const std::string& otherwise) {
  const bool holds = std::abs(figure - expected) <= share * std::abs(expected);
  return {holds ? Outcome::Holds : Outcome::Fails, figure, expected, holds ? "" : otherwise};
}

std::string trialName(const Trial& trial) {
  return std::string(nameOf(trial.method)) + ' ' + std::to_string(std::llround(1 / trial.step)) +
         ' ' + trial.mode;
}

namespace {

struct Job {
  StabilityRow row;
  std::function<Verdict(const Trial&)> run;
};

void addJobs(std::vector<Job>& jobs, const StabilityScene& scene,
             const StabilitySettings& settings) {
  const auto store = std::make_shared<ShapeStore>();
  for (const Method method : scene.methods) {
    if (!settings.method.empty() && nameOf(method) != settings.method) continue;
    for (const double step : scene.steps)
      for (const std::string& mode : scene.modes) {
        if (settings.quick && (step != scene.steps[0] || mode != scene.modes[0])) continue;
        const Trial trial{method, step, mode, store, settings.iterations, {}, {}};
        if (trialName(trial).find(settings.trials) == std::string::npos) continue;
        Job& job = jobs.emplace_back();
        job.row.scene = scene.name, job.row.group = scene.group, job.row.rule = scene.rule;
        job.row.trial = trial, job.row.timed = scene.timed;
        job.run = scene.run;
      }
  }
}

std::vector<Job> jobsOf(const StabilitySettings& settings) {
  std::vector<Job> jobs;
  for (const StabilityScene& scene : allScenes()) {
    if (scene.name.find(settings.only) == std::string::npos) continue;
    if (!settings.quick || scene.cost <= kQuickCost) addJobs(jobs, scene, settings);
  }
  return jobs;
}

Verdict verdictOf(const Job& job) {
  try {
    return job.run(job.row.trial);
  } catch (const std::exception& error) {
    return {Outcome::Cannot, 0, 0, error.what()};
  }
}

void runJob(Job& job) {
  const auto start = std::chrono::steady_clock::now();
  job.row.trial.cost = std::make_shared<TrialCost>();
  job.row.verdict = verdictOf(job);
  job.row.cost = *job.row.trial.cost;
  job.row.trial.store.reset(), job.row.trial.cost.reset();
  job.row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<StabilityScene> allScenes() {
  std::vector<StabilityScene> all;
  for (const auto& scenes :
       {erlebenScenes(), stackScenes(), mechanismScenes(), motionScenes(), runningScenes()})
    all.insert(all.end(), scenes.begin(), scenes.end());
  return all;
}

std::vector<StabilityRow> runStability(const StabilitySettings& settings) {
  std::vector<Job> jobs = jobsOf(settings);
  std::atomic<std::size_t> next = 0;
  std::size_t done = 0;
  std::mutex reporting;
  const auto run = [&](Job& job) {
    runJob(job);
    const std::lock_guard lock(reporting);
    ++done;
    if (settings.progress) settings.progress(double(done) / double(jobs.size()));
  };
  const auto work = [&] {
    for (std::size_t i = next++; i < jobs.size(); i = next++)
      if (!jobs[i].row.timed) run(jobs[i]);
  };
  std::vector<std::thread> threads;
  for (int t = 1; t < settings.threads; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  for (Job& job : jobs)
    if (job.row.timed) run(job);
  std::vector<StabilityRow> rows;
  for (Job& job : jobs) rows.push_back(std::move(job.row));
  return rows;
}

}  // namespace cloudcontact::program::lab
