// What files in stores are called, and what the environment says of them.
#include "terrain/fetch/store_address.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace foreland::terrain {
namespace {

using Variables = std::map<std::string, std::string>;

Environment having(Variables variables) {
  return [variables = std::move(variables)](const char* name) {
    const auto at = variables.find(name);
    return at == variables.end() ? std::string() : at->second;
  };
}

TEST(StoreAddress, LeavesWebAddressesAsTheyAre) {
  for (const char* name : {"https://a.example/b/earth.fls", "http://127.0.0.1:80/earth.fls?token=x%20y"}) {
    ASSERT_TRUE(isInStore(name));
    const auto address = addressOf(name, having({{"AWS_ACCESS_KEY_ID", "a"}}));
    ASSERT_TRUE(address.ok());
    EXPECT_EQ(address->url, name);
    EXPECT_FALSE(address->isSigned());
  }
  EXPECT_FALSE(isInStore("scenes/earth.fls") || isInStore("/s3/earth.fls") || isInStore("ftp://a/b"));
  EXPECT_FALSE(addressOf("earth.fls", having({})).ok());
}

TEST(StoreAddress, PutsASuffixBeforeTheQuery) {
  const auto signed_by_query = addressOf("https://a.example/e.fls?sig=1#x", having({}));
  EXPECT_EQ(signed_by_query->withSuffix(".sums").url, "https://a.example/e.fls.sums?sig=1#x");
  const auto object = addressOf("s3://b/e?.fls", having({{"AWS_REGION", "r"}}));
  EXPECT_EQ(object->withSuffix(".sums").url, "https://b.s3.r.amazonaws.com/e%3F.fls.sums");
  EXPECT_EQ(object->withSuffix(".sums").name, "s3://b/e?.fls.sums");
}

TEST(StoreAddress, FindsBucketsByTheEnvironment) {
  const Variables keys{{"AWS_ACCESS_KEY_ID", "id"}, {"AWS_SECRET_ACCESS_KEY", "secret"}, {"AWS_SESSION_TOKEN", "t"}};
  const auto usual = addressOf("s3://my-bucket/a b/earth.fls", having(keys));
  ASSERT_TRUE(usual.ok());
  EXPECT_EQ(usual->url, "https://my-bucket.s3.us-east-1.amazonaws.com/a%20b/earth.fls");
  EXPECT_TRUE(usual->isSigned());
  EXPECT_EQ(usual->key_id + usual->secret + usual->token + usual->region, "idsecrettus-east-1");
  EXPECT_EQ(addressOf("s3://my.bucket/e", having({{"AWS_DEFAULT_REGION", "eu-1"}}))->url,
            "https://s3.eu-1.amazonaws.com/my.bucket/e");
  const auto own = addressOf("s3://b/e", having({{"AWS_ENDPOINT_URL", "http://127.0.0.1:4568/"}, {"AWS_REGION", "x"}}));
  EXPECT_EQ(own->url, "http://127.0.0.1:4568/b/e");
  EXPECT_FALSE(own->isSigned());
}

TEST(StoreAddress, NamesWhatIsWrong) {
  const auto messageOf = [](const char* name, const Variables& variables) {
    const auto address = addressOf(name, having(variables));
    return address.ok() ? std::string() : address.error().message;
  };
  for (const char* name : {"s3://", "s3://b", "s3://b/", "s3:///e"})
    EXPECT_NE(messageOf(name, {}).find("s3://BUCKET/KEY"), std::string::npos) << name;
  EXPECT_NE(messageOf("s3://B@c/e", {}).find("names of buckets"), std::string::npos);
  EXPECT_NE(messageOf("s3://b/e", {{"AWS_ACCESS_KEY_ID", "id"}}).find("AWS_SECRET_ACCESS_KEY"), std::string::npos);
  EXPECT_NE(messageOf("s3://b/e", {{"AWS_ENDPOINT_URL", "here"}}).find("AWS_ENDPOINT_URL"), std::string::npos);
}

}  // namespace
}  // namespace foreland::terrain
