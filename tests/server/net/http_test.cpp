// What plain HTTP may reach, without a socket: the page's files, the instruments, and never anything else.
#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/net/http_reply.h"
#include "server/net/listen_address.h"
#include "server/net/metrics.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

namespace fs = std::filesystem;

void writeFile(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

// A page of two files beside a secret, one link to the secret inside.
class Site : public testing::Test {
 protected:
  void SetUp() override {
    writeFile(folder_ / "secret.txt", "secret");
    writeFile(folder_ / "web/index.html", "<html>");
    writeFile(folder_ / "web/assets/core-1234.wasm", "\0asm");
    fs::create_symlink(folder_ / "secret.txt", folder_ / "web/link.txt");
    auto files = StaticFiles::load(folder_ / "web");
    ASSERT_TRUE(files.ok()) << files.error().message;
    site_ = {.files = *files, .metrics = [] { return std::string("foreland_sessions 0"); }};
  }
  HttpReply get(std::string_view target, std::string_view known = {}) const {
    return replyTo({.method = "GET", .target = target, .if_none_match = known}, site_);
  }

  test::TemporaryFolder folder_;
  HttpSite site_;
};

TEST_F(Site, NoTargetReachesTheSecret) {
  for (const char* target :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/assets/../../secret.txt", "//secret.txt",
        "/link.txt", "/\\..\\secret.txt", "/..;/secret.txt", "/%2e%2e%2fsecret.txt%00.html", ""}) {
    EXPECT_GE(get(target).status, 400u) << target;
    EXPECT_EQ(get(target).body->find("secret"), std::string::npos) << target;
  }
  EXPECT_GE(get((folder_ / "secret.txt").string()).status, 400u);
}

TEST_F(Site, AnyTargetGetsAWholeReply) {
  EXPECT_TRUE(rc::check([this](const std::string& target) {
    const HttpReply reply = get("/" + target);
    RC_ASSERT(reply.body != nullptr);
    RC_ASSERT(*reply.body != "secret");
  }));
}

TEST_F(Site, ServesFilesWithTheirTypesAndCacheRules) {
  const HttpReply index = get("/?x=1#top");
  EXPECT_EQ(index.status, 200u);
  EXPECT_EQ(*index.body, "<html>");
  EXPECT_EQ(index.content_type, "text/html; charset=utf-8");
  EXPECT_EQ(index.cache_control, "no-cache");
  const HttpReply wasm = get("/assets/core%2D1234.wasm");
  EXPECT_EQ(wasm.status, 200u);
  EXPECT_EQ(wasm.content_type, "application/wasm");
  EXPECT_NE(wasm.cache_control.find("immutable"), std::string::npos);
}

TEST_F(Site, SendsAFileOnceToWhoKnowsIt) {
  const HttpReply again = get("/index.html", get("/index.html").etag);
  EXPECT_EQ(again.status, 304u);
  EXPECT_TRUE(again.body->empty());
}

TEST_F(Site, TellsWhoStraysWhereToGo) {
  EXPECT_EQ(get("/healthz").status, 200u);
  EXPECT_EQ(get("/fly").status, 426u);
  EXPECT_NE(get("/fly").body->find("WebSocket"), std::string::npos);
  EXPECT_EQ(get("/nothing").status, 404u);
  EXPECT_EQ(get("/%zz").status, 400u);
  EXPECT_EQ(replyTo({.method = "POST", .target = "/", .if_none_match = {}}, site_).status, 405u);
}

TEST(StaticFiles, RefusesWhatIsNoPage) {
  const test::TemporaryFolder folder;
  for (const fs::path& path : {folder / "missing", folder.path()}) {
    const auto files = StaticFiles::load(path);
    ASSERT_FALSE(files.ok());
    EXPECT_NE(files.error().message.find(path.string()), std::string::npos) << files.error().message;
  }
}

TEST(ListenAddress, ReadsWhatItWrites) {
  for (const char* text : {"127.0.0.1:8080", "[::1]:80", "0.0.0.0:0", "[::]:65535"}) {
    const auto address = parseListenAddress(text);
    ASSERT_TRUE(address.ok()) << text;
    EXPECT_EQ(toString(*address), text);
  }
  EXPECT_EQ(toString(*parseListenAddress("localhost:1")), "127.0.0.1:1");
  EXPECT_EQ(toString(*parseListenAddress("9000")), "127.0.0.1:9000");
}

TEST(ListenAddress, RefusesWhatIsNone) {
  for (const char* text : {"", ":", "x", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "::1:80", "[127.0.0.1]:80",
                           "[]:1", "example.org:80", "127.0.0.1:80x"}) {
    const auto address = parseListenAddress(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_NE(address.error().message.find("'" + std::string(text) + "'"), std::string::npos);
  }
}

TEST(Metrics, HistogramsAreCumulativeAndEndInTheCount) {
  Metrics metrics;
  metrics.compute.add(Duration::milliseconds(2));
  metrics.compute.add(Duration::seconds(9));
  const std::string page = renderPrometheus(metrics, {});
  EXPECT_NE(page.find("foreland_compute_seconds_bucket{le=\"0.0001\"} 0\n"), std::string::npos);
  EXPECT_NE(page.find("foreland_compute_seconds_bucket{le=\"0.0025\"} 1\n"), std::string::npos);
  EXPECT_NE(page.find("foreland_compute_seconds_bucket{le=\"+Inf\"} 2\n"), std::string::npos);
  EXPECT_NE(page.find("foreland_compute_seconds_count 2\n"), std::string::npos);
}

}  // namespace
}  // namespace foreland::server
