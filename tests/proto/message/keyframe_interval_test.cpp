#include "proto/message/keyframe_interval.h"

#include <gtest/gtest.h>

namespace foreland::proto {
namespace {

Duration ms(int64_t n) { return Duration::milliseconds(n); }

TEST(KeyframeInterval, IsReadAsItIsWritten) {
  for (const KeyframeInterval& interval :
       {KeyframeInterval{ms(20), {}}, KeyframeInterval{ms(200), {}}, KeyframeInterval{ms(10'000), {}},
        KeyframeInterval{ms(100), ms(500)}, KeyframeInterval{ms(20), ms(10'000)}, kAdaptiveInterval}) {
    const auto read = keyframeIntervalFrom(textOf(interval));
    ASSERT_TRUE(read.ok()) << textOf(interval);
    EXPECT_EQ(*read, interval) << textOf(interval);
  }
  EXPECT_EQ(textOf(kAdaptiveInterval), "adaptive");
  EXPECT_TRUE(kAdaptiveInterval.isAdaptive());
  EXPECT_FALSE(KeyframeInterval{}.isAdaptive());
  EXPECT_EQ(KeyframeInterval{}.most(), ms(200));
  EXPECT_EQ((KeyframeInterval{ms(100), ms(500)}.most()), ms(500));
}

TEST(KeyframeInterval, IsRefusedByItsText) {
  for (const char* text : {"", "0", "19", "10001", "-5", "200.5", "200 ms", "adaptiv", "Adaptive", "500-100", "200-200",
                           "100-", "-100", "100-10001", "10-100", "100-500-900", "99999999999999999999"}) {
    const auto read = keyframeIntervalFrom(text);
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_NE(read.error().message.find("not " + std::string(text)), std::string::npos) << read.error().message;
  }
}

}  // namespace
}  // namespace foreland::proto
