#include "base/lines.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace foreland {
namespace {

std::vector<std::string> linesOf(std::string_view text) {
  std::vector<std::string> found;
  Lines lines(text);
  for (std::string_view line; lines.next(line);) found.emplace_back(line);
  EXPECT_EQ(lines.number(), found.size());
  EXPECT_TRUE(lines.rest().empty());
  return found;
}

TEST(Lines, EndInAnyWay) {
  const std::vector<std::string> expected{"a", "", "bc", "d"};
  for (const char* text : {"a\n\nbc\nd", "a\n\nbc\nd\n", "a\r\n\r\nbc\r\nd\r\n", "a\r\rbc\rd\r", "a\n\rbc\r\nd"})
    EXPECT_EQ(linesOf(text), expected) << testing::PrintToString(text);
  EXPECT_EQ(linesOf(""), std::vector<std::string>());
  EXPECT_EQ(linesOf("\r\n"), std::vector<std::string>{""});
}

}  // namespace
}  // namespace foreland
