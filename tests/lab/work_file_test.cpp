// The file of counts: growth beyond 3 % is a fault, a fall good news, and both are named.
#include "lab/work_file.h"

#include <gtest/gtest.h>

namespace cloudcontact::program::lab::work_file_test {
namespace {

const Json kBefore =
    Json::parse(R"({"pair a": {"searches": 2, "hits": 0}, "pair b": {"searches": 5}})");

WorkChanges of(double searches, double hits) {
  return compared(kBefore, {{"pair a", {{"searches", searches}, {"hits", hits}}}});
}

TEST(WorkFile, NamesWhatGrew) {
  EXPECT_TRUE(of(2.059, 0).faults.empty());
  const WorkChanges grown = of(2.061, 0);
  ASSERT_EQ(grown.faults.size(), 1u);
  EXPECT_EQ(grown.faults[0], "pair a: searches 2.061, was 2 (+3.0 %)");
  EXPECT_TRUE(grown.news.empty());
}

TEST(WorkFile, WhatWasNoneMayNotBeginToBe) {
  ASSERT_EQ(of(2, 1).faults.size(), 1u);
  EXPECT_EQ(of(2, 1).faults[0], "pair a: hits 1, was 0");
}

TEST(WorkFile, WhatFellIsGoodNews) {
  const WorkChanges fallen = of(1, 0);
  EXPECT_TRUE(fallen.faults.empty());
  ASSERT_EQ(fallen.news.size(), 1u);
  EXPECT_EQ(fallen.news[0], "pair a: searches 1, was 2 (-50.0 %)");
  EXPECT_TRUE(of(1.941, 0).news.empty());
}

TEST(WorkFile, WhatTheFileLacksIsAFault) {
  EXPECT_EQ(compared(kBefore, {{"pair c", {}}}).faults.at(0), "pair c: not in the file");
}

// A checkout without ../shared keeps the counts of its scenes.
TEST(WorkFile, WritesWhatItReadsAndKeepsTheRest) {
  const std::string text = workText(kBefore, {{"pair a", {{"searches", 3}, {"hits", 1.0 / 3}}}});
  const Json now = Json::parse(text);
  EXPECT_EQ(now["pair b"], kBefore["pair b"]);
  EXPECT_TRUE(compared(now, {{"pair a", {{"searches", 3}, {"hits", 1.0 / 3}}}}).faults.empty());
  EXPECT_EQ(workText(now, {}), text);
}

}  // namespace
}  // namespace cloudcontact::program::lab::work_file_test
