#include "apps/report/summary.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace foreland::apps {
namespace {

TEST(Summary, HasThreeDigits) {
  const std::vector<std::pair<double, const char*>> cases{
      {0, "0"},           {0.94321, "0.943"},      {0.0123456, "0.0123"},
      {0.001, "0.00100"}, {0.0009, "below 0.001"}, {1, "1.00"},
      {9.994, "9.99"},    {9.996, "10.0"},         {60, "60.0"},
      {99.96, "100"},     {386.4, "386"},          {999.6, "1,000"},
      {1207, "1,210"},    {396957, "397,000"},     {1234567890, "1,230,000,000"},
      {-15.64, "-15.6"},  {-1234567, "-1,230,000"}};
  for (const auto& [value, expected] : cases) EXPECT_EQ(digits(value), expected) << value;
  EXPECT_EQ(digits(std::numeric_limits<double>::infinity()), "infinite");
  EXPECT_EQ(digits(std::numeric_limits<double>::quiet_NaN()), "none");
}

TEST(Summary, WritesWhatWasAskedForAsPeopleDo) {
  for (const auto& [value, expected] :
       {std::pair{60.0, "60"}, {1.0, "1"}, {1.5, "1.5"}, {0.25, "0.25"}, {200.0, "200"}, {0.0, "0"}, {5000.0, "5,000"}})
    EXPECT_EQ(shortest(value), expected) << value;
}

TEST(Summary, HasUnits) {
  EXPECT_EQ(bytesText(0), "0 bytes");
  EXPECT_EQ(bytesText(845), "845 bytes");
  EXPECT_EQ(bytesText(999.6), "1.00 kB");
  EXPECT_EQ(bytesText(312'400), "312 kB");
  EXPECT_EQ(bytesText(999'600), "1.00 MB");
  EXPECT_EQ(bytesText(7.5e15), "7,500 TB");
  EXPECT_EQ(millisecondsText(386.38), "386 ms");
  EXPECT_EQ(millisecondsText(999.7), "1.00 s");
  EXPECT_EQ(millisecondsText(12'345), "12.3 s");
  EXPECT_EQ(count(1207), "1,207");
  EXPECT_EQ(count(12), "12");
  EXPECT_EQ(count(123'456'789), "123,456,789");
  EXPECT_EQ(count(1, "crack"), "1 crack");
  EXPECT_EQ(count(0, "crack"), "0 cracks");
}

TEST(Summary, EndsWithWhetherAllIsWell) {
  Summary summary;
  summary.add("frames", "60.0 of 60 a second");
  summary.add("", "12 of them late");
  EXPECT_EQ(summary.text(Paint::kPlain),
            "frames      60.0 of 60 a second\n"
            "            12 of them late\n"
            "all is well\n");
  summary.addProblem("3 of 100 keyframes came late", "ask for less");
  summary.addProblem("interrupted");
  EXPECT_EQ(summary.text(Paint::kPlain),
            "frames      60.0 of 60 a second\n"
            "            12 of them late\n"
            "not well    3 of 100 keyframes came late; ask for less\n"
            "not well    interrupted\n");
}

TEST(Summary, HasColoursForTheVerdictOnly) {
  Summary summary;
  summary.add("frames", "60.0 of 60 a second");
  EXPECT_EQ(summary.text(Paint::kColours), "frames      60.0 of 60 a second\n\033[1;32mall is well\033[0m\n");
  summary.addProblem("late");
  EXPECT_EQ(summary.text(Paint::kColours), "frames      60.0 of 60 a second\n\033[1;31mnot well\033[0m    late\n");
}

// A terminal without anybody before it.
class Terminal {
 public:
  Terminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    if (master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0) out_ = std::fopen(::ptsname(master_), "w");
  }
  ~Terminal() {
    if (out_) std::fclose(out_);
    if (master_ >= 0) ::close(master_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  std::FILE* out() const { return out_; }

 private:
  int master_;
  std::FILE* out_ = nullptr;
};

// Sets a variable of the environment, and puts it back.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    value ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(Summary, HasColoursOnTerminalsOfThoseWhoWantThem) {
  const Terminal terminal;
  if (!terminal.out()) GTEST_SKIP() << "this system gives no terminal";
  const Variable kind("TERM", "xterm");
  {
    const Variable no_color("NO_COLOR", nullptr);
    EXPECT_EQ(paintFor(terminal.out()), Paint::kColours);
    std::FILE* file = std::tmpfile();
    EXPECT_EQ(paintFor(file), Paint::kPlain);
    std::fclose(file);
    const Variable dumb("TERM", "dumb");
    EXPECT_EQ(paintFor(terminal.out()), Paint::kPlain);
  }
  const Variable empty("NO_COLOR", "");
  EXPECT_EQ(paintFor(terminal.out()), Paint::kColours);
  const Variable set("NO_COLOR", "1");
  EXPECT_EQ(paintFor(terminal.out()), Paint::kPlain);
}

}  // namespace
}  // namespace foreland::apps
