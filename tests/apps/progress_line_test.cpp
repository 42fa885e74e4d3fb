#include "apps/report/progress_line.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace foreland::apps {
namespace {

using namespace std::chrono_literals;
using Clock = ProgressLine::Clock;

// A file in memory.
class Output {
 public:
  Output() : file_(::open_memstream(&text_, &size_)) {}
  ~Output() {
    std::fclose(file_);
    std::free(text_);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  std::FILE* file() const { return file_; }
  std::string text() const { return std::fflush(file_), std::string(text_, size_); }

 private:
  char* text_ = nullptr;
  size_t size_ = 0;
  std::FILE* file_;
};

const Clock::time_point kBegin = Clock::time_point() + 1h;

TEST(ProgressLine, WritesALineEachHalfMinuteWhereThereIsNoTerminal) {
  const Output out;
  ProgressLine line(out.file(), ProgressLine::Kind::kLines);
  for (int second = 0; second <= 100; ++second)
    line.show("judging frames", second / 100.0, kBegin + std::chrono::seconds(second));
  line.end();
  EXPECT_EQ(out.text(),
            "judging frames\n"
            "judging frames: 30 %, 1 min 10 s left\n"
            "judging frames: 60 %, 40 s left\n"
            "judging frames: 90 %, 10 s left\n");
}

TEST(ProgressLine, NamesEachStage) {
  const Output out;
  ProgressLine line(out.file(), ProgressLine::Kind::kLines);
  line.show("one", 0, kBegin);
  line.show("one", 1, kBegin + 1s);
  line.show("two", 0, kBegin + 2s);
  line.show("two", 0.01, kBegin + 40s);
  line.end();
  EXPECT_EQ(out.text(), "one\ntwo\ntwo: 1 %\n");
}

TEST(ProgressLine, RedrawsItsLineOnATerminalAndNoMoreOftenThanCanBeRead) {
  const Output out;
  ProgressLine line(out.file(), ProgressLine::Kind::kRedrawn);
  line.show("bounds", 0, kBegin);
  line.show("bounds", 0.4, kBegin + 50ms);
  line.show("bounds", 0.5, kBegin + 10s);
  line.show("bounds", 1, kBegin + 10s + 1ms);
  line.end();
  const std::string half(15, '#'), rest(15, ' '), whole(30, '#'), none(30, ' ');
  EXPECT_EQ(out.text(), "\r  bounds         [" + none + "]   0 %                    " +  //
                            "\r  bounds         [" + half + rest + "]  50 %, 10 s left         " +
                            "\r  bounds         [" + whole + "] 100 %                    \n");
}

TEST(ProgressLine, SaysNothingIfThereWasNothingToDo) {
  for (const auto kind : {ProgressLine::Kind::kRedrawn, ProgressLine::Kind::kLines}) {
    const Output out;
    ProgressLine(out.file(), kind).end();
    EXPECT_EQ(out.text(), "");
  }
}

}  // namespace
}  // namespace foreland::apps
