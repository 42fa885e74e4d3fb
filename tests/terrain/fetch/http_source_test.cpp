// Redirections of stores, which are followed but where a request is signed.
#include "terrain/fetch/http_source.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "tests/support/files.h"
#include "tests/support/plain_web_server.h"

namespace foreland::terrain {
namespace {

// What a store has under the name of a folder, which it leads elsewhere from.
Result<Bytes> fetchMoved(const std::string& name, std::map<std::string, std::string> variables) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "bucket/moved.fls");
  test::spit(folder / "bucket/moved.fls/index.html", {'m', 'o', 'v', 'e', 'd'});
  const test::PlainWebServer store(folder.path());
  variables["AWS_ENDPOINT_URL"] = store.address();
  const auto address = addressOf(name.starts_with('/') ? store.address() + name : name,
                                 [&](const char* variable) { return variables[variable]; });
  if (!address) return address.error();
  return fetchWhole(*address, 100);
}

TEST(HttpSource, FollowsRedirectionsOfWhatIsNotSigned) {
  const Bytes moved{'m', 'o', 'v', 'e', 'd'};
  for (const char* name : {"/bucket/moved.fls", "s3://bucket/moved.fls"}) {
    const auto fetched = fetchMoved(name, {});
    ASSERT_TRUE(fetched.ok()) << fetched.error().message;
    EXPECT_EQ(*fetched, moved);
  }
}

TEST(HttpSource, SendsNoSignedRequestToWhereItIsLed) {
  const auto fetched =
      fetchMoved("s3://bucket/moved.fls",
                 {{"AWS_ACCESS_KEY_ID", "id"}, {"AWS_SECRET_ACCESS_KEY", "secret"}, {"AWS_SESSION_TOKEN", "token"}});
  ASSERT_FALSE(fetched.ok());
  for (const char* word : {"s3://bucket/moved.fls", "leads elsewhere (301)", "AWS_REGION", "AWS_ENDPOINT_URL"})
    EXPECT_NE(fetched.error().message.find(word), std::string::npos) << fetched.error().message;
}

}  // namespace
}  // namespace foreland::terrain
