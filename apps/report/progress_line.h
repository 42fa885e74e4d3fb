// Shows on standard error how far a long piece of work has come: on a terminal by one line that is redrawn, with a bar
// and the time left; otherwise by one line for each stage, and then one each half minute. Header only; one thread.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

namespace foreland::apps {

// Whole seconds, or minutes and seconds.
inline std::string timeText(double seconds) {
  const long whole = std::lround(std::ceil(seconds));
  return whole < 60 ? std::to_string(whole) + " s"
                    : std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
}

class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Kind { kRedrawn, kLines };

  explicit ProgressLine(std::FILE* out = stderr)
      : ProgressLine(out, isatty(fileno(out)) == 1 ? Kind::kRedrawn : Kind::kLines) {}
  ProgressLine(std::FILE* out, Kind kind) : out_(out), kind_(kind) {}

  // `share` of the stage is done, from 0 to 1. Nothing is written more often than can be read.
  void show(std::string_view stage, double share, Clock::time_point now = Clock::now()) {
    if (stage != stage_) begin(stage, now);
    if (kind_ == Kind::kRedrawn)
      redraw(share, now);
    else if (now - drawn_ >= kBetweenLines)
      writeLine(share, now);
  }
  void end() {
    if (kind_ == Kind::kRedrawn && !stage_.empty()) std::fputs("\n", out_);
    stage_.clear();
  }

 private:
  static constexpr int kBar = 30;
  static constexpr std::chrono::milliseconds kBetweenDrawings{100};
  static constexpr std::chrono::seconds kBetweenLines{30};
  static constexpr double kMinShare = 0.02;  // before it, the time left cannot be told

  void begin(std::string_view stage, Clock::time_point now) {
    end();
    stage_ = stage;
    begun_ = now;
    drawn_ = kind_ == Kind::kRedrawn ? Clock::time_point() : now;
    if (kind_ == Kind::kLines) std::fprintf(out_, "%s\n", stage_.c_str());
    std::fflush(out_);
  }

  void redraw(double share, Clock::time_point now) {
    if (share < 1 && now - drawn_ < kBetweenDrawings) return;
    drawn_ = now;
    const int filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * kBar);
    std::fprintf(out_, "\r  %-14s [%.*s%*s] %3.0f %%%-20s", stage_.c_str(), filled, "##############################",
                 kBar - filled, "", share * 100, left(share, now).c_str());
    std::fflush(out_);
  }

  void writeLine(double share, Clock::time_point now) {
    drawn_ = now;
    std::fprintf(out_, "%s: %.0f %%%s\n", stage_.c_str(), share * 100, left(share, now).c_str());
    std::fflush(out_);
  }

  std::string left(double share, Clock::time_point now) const {
    if (!(share > kMinShare && share < 1)) return {};
    const double elapsed_s = std::chrono::duration<double>(now - begun_).count();
    return ", " + timeText(elapsed_s * (1 - share) / share) + " left";
  }

  std::FILE* out_;
  Kind kind_;
  std::string stage_;
  Clock::time_point begun_, drawn_;
};

}  // namespace foreland::apps
