// What plain HTTP may reach, without a socket: the page's files, the instruments, and never anything else.
#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <zlib.h>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/net/access/listen_address.h"
#include "server/net/http/http_fields.h"
#include "server/net/http/http_reply.h"
#include "server/net/metrics/metrics.h"
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

TEST_F(Site, IsNotReadyForTheReasonThatItIsGiven) {
  HttpSite site{.files = {}, .metrics = {}, .unready = [] { return std::string("The server is overloaded."); }};
  for (const char* path : {"/readyz", "/healthz"}) {
    const HttpReply reply = replyTo({.method = "GET", .target = path, .if_none_match = {}}, site);
    EXPECT_EQ(reply.status, 503u) << path;
    EXPECT_NE(reply.content().find("overloaded"), std::string::npos) << reply.content();
  }
  EXPECT_EQ(replyTo({.method = "GET", .target = "/livez", .if_none_match = {}}, site).status, 200u);
}

TEST_F(Site, OfSeveralScenesHasThePageAtEachOfThem) {
  site_.files.add("/scenes.html", "the list");
  site_.files.add("/hills/models/0.rgba", "hills");
  site_.files.add("/alps/models/0.rgba", "alps");
  site_.scenes = {"hills", "alps"};
  EXPECT_EQ(get("/").content(), "the list");
  for (const std::string name : {"hills", "alps"}) {
    EXPECT_EQ(get("/" + name + "/").content(), "<html>");
    EXPECT_EQ(get("/" + name + "/index.html?view=1").content(), "<html>");
    EXPECT_EQ(get("/" + name + "/assets/core-1234.wasm").status, 200u);
    EXPECT_EQ(get("/" + name + "/models/0.rgba").content(), name);
    EXPECT_EQ(get("/" + name + "/fly").status, 426u);
    EXPECT_TRUE(isForViewers("/" + name + "/fly?token=1", site_));
    EXPECT_FALSE(isForViewers("/" + name + "/", site_));
    // Relative, so that it holds below a path that a proxy takes off.
    EXPECT_EQ(get("/" + name + "?view=1").status, 308u);
    EXPECT_EQ(get("/" + name + "?view=1").location, name + "/?view=1");
  }
  EXPECT_FALSE(isForViewers("/fly", site_));
}

TEST_F(Site, OfSeveralScenesHasNothingBesideThem) {
  site_.files.add("/scenes.html", "the list");
  site_.files.add("/alps/models/0.rgba", "alps");
  site_.scenes = {"hills", "alps"};
  for (const char* target :
       {"/index.html", "/assets/core-1234.wasm", "/fly", "/hill/", "/hills/alps/models/0.rgba", "/hills/models/0.rgba",
        "/hills/../alps/models/0.rgba", "/hills/alps/", "/%2e%2e/", "/hills//"})
    EXPECT_EQ(get(target).status, 404u) << target;
  const std::string told(get("/zugspitze/").content());
  EXPECT_NE(told.find("/hills/, /alps/"), std::string::npos) << told;
  for (const char* target : {"/livez", "/readyz", "/metrics"}) EXPECT_EQ(get(target).status, 200u) << target;
}

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

TEST_F(Site, LeavesOutNamesThatBeginWithADot) {
  writeFile(folder_ / "web/.env", "secret");
  writeFile(folder_ / "web/.git/config", "secret");
  writeFile(folder_ / "web/assets/.hidden.js", "secret");
  const auto files = StaticFiles::load(folder_ / "web");
  ASSERT_TRUE(files.ok());
  for (const char* path : {"/.env", "/.git/config", "/assets/.hidden.js"})
    EXPECT_EQ(files->find(path), nullptr) << path;
  EXPECT_NE(files->find("/"), nullptr);
}

// Whatever form is sent, it is a form of the file, and is smaller.
TEST_F(Site, CompressesForWhoTakesIt) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += "line " + std::to_string(i) + "\n";
  writeFile(folder_ / "web/lines.txt", text);
  site_.files = StaticFiles::load(folder_ / "web").value();
  const auto encoded = [&](std::string_view accepted, std::string_view known = {}) {
    return replyTo({.method = "GET", .target = "/lines.txt", .if_none_match = known, .accept_encoding = accepted},
                   site_);
  };
  const HttpReply plain = encoded(""), gzip = encoded("deflate, gzip;q=0.5"), brotli = encoded("gzip, deflate, br");
  EXPECT_EQ(plain.content(), text);
  EXPECT_EQ(gzip.encoding, "gzip");
  EXPECT_EQ(brotli.encoding, "br");
  EXPECT_LT(brotli.content().size(), gzip.content().size());
  EXPECT_LT(3 * gzip.content().size(), text.size());
  EXPECT_TRUE(plain.varies && gzip.varies);
  EXPECT_NE(gzip.etag, plain.etag);
  EXPECT_EQ(encoded("br;q=0, gzip;q=0.0").encoding, "");
  EXPECT_EQ(encoded("*").encoding, "") << "what is not named is not taken";
  EXPECT_EQ(encoded("br", brotli.etag).status, 304u);
  EXPECT_EQ(encoded("br", plain.etag).status, 200u) << "another form";

  std::string unpacked(text.size() + 1, '\0');
  z_stream stream{};
  ASSERT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);
  const std::string packed(gzip.content());
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
  stream.avail_out = static_cast<uInt>(unpacked.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  unpacked.resize(stream.total_out);
  EXPECT_EQ(unpacked, text);
  inflateEnd(&stream);
}

// The parts that a client asks for, put together, are the file.
TEST_F(Site, SendsParts) {
  site_.files.add("/digits.bin", "0123456789");
  const auto part = [&](std::string_view range, std::string_view if_range = {}) {
    return replyTo({.method = "GET",
                    .target = "/digits.bin",
                    .if_none_match = {},
                    .accept_encoding = "br, gzip",
                    .range = range,
                    .if_range = if_range},
                   site_);
  };
  EXPECT_EQ(part("bytes=0-3").content(), "0123");
  EXPECT_EQ(part("bytes=4-").content(), "456789");
  EXPECT_EQ(part("bytes=-3").content(), "789");
  EXPECT_EQ(part("bytes=8-99").content(), "89");
  EXPECT_EQ(part("bytes=2-2").content_range, "bytes 2-2/10");
  EXPECT_EQ(part("bytes=2-2").status, 206u);
  for (const char* none : {"bytes=10-", "bytes=-0", "bytes=99-100"}) {
    EXPECT_EQ(part(none).status, 416u) << none;
    EXPECT_EQ(part(none).content_range, "bytes */10") << none;
  }
  for (const char* whole : {"", "bytes=", "bytes=-", "bytes=3-2", "bytes=a-b", "bytes=1-2,4-5", "lines=1-2", "bytes=1",
                            "bytes=99999999999999999999999-"}) {
    EXPECT_EQ(part(whole).status, 200u) << whole;
    EXPECT_EQ(part(whole).content(), "0123456789") << whole;
  }
  const std::string etag = part("").etag;
  EXPECT_EQ(part("bytes=0-3", etag).status, 206u);
  EXPECT_EQ(part("bytes=0-3", "\"another\"").status, 200u) << "the file has changed since";
}

TEST_F(Site, AnyFieldsGetAPartOfTheFile) {
  EXPECT_TRUE(rc::check([this](const std::string& range, const std::string& accepted, const std::string& known) {
    const HttpReply reply = replyTo({.method = "GET",
                                     .target = "/index.html",
                                     .if_none_match = known,
                                     .accept_encoding = accepted,
                                     .range = "bytes=" + range},
                                    site_);
    RC_ASSERT(reply.content().size() <= reply.body->size());
    RC_ASSERT(reply.status != 206 || std::string_view("<html>").find(reply.content()) != std::string_view::npos);
  }));
}

TEST(EntityTags, AreFoundInListsWeakOrNot) {
  for (const char* list : {"\"a\"", "W/\"a\"", "\"b\", \"a\"", "\"b\" ,W/\"a\",\"c\"", "*"})
    EXPECT_TRUE(namesTag(list, "\"a\"")) << list;
  for (const char* list : {"", "a", "\"b\"", "\"b\",", "\"aa\", \"b\"", "w/\"a\""})
    EXPECT_FALSE(namesTag(list, "\"a\"")) << list;
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
