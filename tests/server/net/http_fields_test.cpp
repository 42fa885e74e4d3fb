#include "server/net/http/http_fields.h"

#include <gtest/gtest.h>

namespace foreland::server {
namespace {

TEST(AcceptsCodingTest, ReadsTheWeightAndNoOtherParameter) {
  EXPECT_TRUE(acceptsCoding("gzip", "gzip"));
  EXPECT_TRUE(acceptsCoding("deflate, GZip;q=0.001", "gzip"));
  EXPECT_FALSE(acceptsCoding("gzip;q=0, br", "gzip"));
  EXPECT_FALSE(acceptsCoding("gzip; Q=0.000", "gzip"));
  EXPECT_FALSE(acceptsCoding("xgzip, gzip2", "gzip"));
  EXPECT_TRUE(acceptsCoding("gzip;seq=0", "gzip")) << "a parameter whose name ends in q";
  EXPECT_TRUE(acceptsCoding("gzip;seq=0;q=1", "gzip"));
  EXPECT_FALSE(acceptsCoding("gzip;xq=1;q=0", "gzip"));
}

}  // namespace
}  // namespace foreland::server
