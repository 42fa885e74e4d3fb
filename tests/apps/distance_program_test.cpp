// A scene that is served from a store, as people do it: checksums beside it, a cache that does not hold it all, and a
// store that dies meanwhile. And what is said of a store that will not do.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/apps/expect_refusal.h"
#include "tests/server/net/client.h"
#include "tests/support/files.h"
#include "tests/support/plain_web_server.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

class DistanceProgram : public testing::Test {
 protected:
  // The folder is what the store has; a server's own pages answer ranges.
  void make(uint32_t side) const {
    FormulaSource source(side, side, hills(3));
    ASSERT_TRUE(terrain::buildScene(source, {.output = scene(), .height_quantum_m = 0.1, .threads = 1}).ok());
    spit(folder_ / "index.html", {'<', 'p', '>'});
    const ProgramResult sums = runProgram("sums", {scene(), "--chunk-kib", "16"});
    ASSERT_EQ(sums.exit_code, 0) << sums.output;
    FormulaSource small(33, 33, hills(1));
    ASSERT_TRUE(terrain::buildScene(small, {.output = small_, .height_quantum_m = 0.1, .threads = 1}).ok());
  }
  std::string scene() const { return folder_ / "far.fls"; }
  std::vector<std::string> store() const {
    return {small_, "--listen", "127.0.0.1:0", "--web", folder_.path().string(), "--log-level", "off"};
  }
  std::vector<std::string> server(const std::string& address) const {
    return {address, "--listen",          "127.0.0.1:0",       "--log-level", "off", "--store-cache-mib",
            "1",     "--store-cache-dir", own_.path().string()};
  }
  // Of two seconds; an Error of the server's would end it.
  static nlohmann::json fly(uint16_t port, const std::string& truth) {
    const ProgramResult flown = runProgram(
        "fly",
        {"ws://127.0.0.1:" + std::to_string(port), "--tour", "jumps", "--seconds", "2", "--truth", truth, "--viewport",
         "320x240", "--keyframe-ms", "100", "--truth-frames", "10", "--truth-terms-every", "0", "--json"},
        {.streams = Streams::kOutputOnly});
    EXPECT_EQ(flown.exit_code, 0) << flown.output;
    return nlohmann::json::parse(flown.output, nullptr, false);
  }
  static void expectTrue(const nlohmann::json& flown) {
    ASSERT_FALSE(flown.is_discarded());
    EXPECT_GT(flown["measured_frames"], 0);
    EXPECT_EQ(flown["keyframes_over_tau"], 0);
    EXPECT_EQ(flown["frames_over_tau"], 0);
    EXPECT_EQ(flown["cracks"], 0);
  }

  TemporaryFolder folder_, own_;
  std::string small_ = own_ / "small.fls";
};

TEST_F(DistanceProgram, ServesWhatFitsAndOutlivesItsStore) {
  make(513);
  Program store("serve", this->store());
  const std::string address = "http://127.0.0.1:" + std::to_string(portOf(store.readLine())) + "/far.fls";
  Program server("serve", this->server(address));
  const uint16_t port = portOf(server.readLine());
  expectTrue(fly(port, scene()));
  EXPECT_GT(metric(port, "store_fetched_chunks_total"), 50);
  EXPECT_GT(metric(port, "store_evicted_chunks_total"), 0);
  EXPECT_LE(metric(port, "store_cache_bytes"), metric(port, "store_capacity_bytes"));
  store.signal(SIGKILL);
  EXPECT_EQ(store.wait(), -1);
  expectTrue(fly(port, scene()));
  EXPECT_GT(metric(port, "store_failures_total{reason=\"read\"}"), 0);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(DistanceProgram, SaysWhatIsWrongWithAStore) {
  make(65);
  Program store("serve", this->store());
  const std::string root = "http://127.0.0.1:" + std::to_string(portOf(store.readLine())) + "/";
  expectRefusal("serve", server(root + "none.fls"), {"none.fls.sums", "404", "foreland sums SCENE.fls"});
  expectRefusal("serve", server("http://127.0.0.1:1/far.fls"), {"cannot be reached", "check the address"});
  expectRefusal("serve", server("s3://bucket"), {"s3://BUCKET/KEY"});
  expectRefusal("sums", {scene() + ".sums"}, {"far.fls.sums"});
  expectRefusal("sums", {scene(), "--chunk-kib", "48"}, {"a power of two"});

  // One that knows no ranges.
  const PlainWebServer plain(folder_.path());
  expectRefusal("serve", server(plain.address() + "/far.fls"), {"answers no ranges", "nginx"});
}

TEST_F(DistanceProgram, KnowsAFileThatIsNotTheOneOfTheChecksums) {
  make(65);
  const std::vector<char> sums = slurp(scene() + ".sums"), bytes = slurp(scene());
  const auto expectRefused = [&](const std::vector<std::string>& words) {
    Program store("serve", this->store());
    const std::string address = "http://127.0.0.1:" + std::to_string(portOf(store.readLine())) + "/far.fls";
    expectRefusal("serve", server(address), words);
  };
  std::vector<char> changed = bytes;
  changed[100] = static_cast<char>(changed[100] ^ 1);
  spit(scene(), changed);
  expectRefused({"far.fls", "foreland sums", "copy the scene there again"});
  spit(scene(), {bytes.begin(), bytes.end() - 4096});
  expectRefused({"far.fls", "copy"});
  spit(scene(), bytes);
  changed = sums;
  changed[50] = static_cast<char>(changed[50] ^ 1);
  spit(scene() + ".sums", changed);
  expectRefused({"far.fls.sums", "it is damaged", "foreland sums"});
  spit(scene() + ".sums", sums);
  Program store("serve", this->store());
  Program server("serve", this->server("http://127.0.0.1:" + std::to_string(portOf(store.readLine())) + "/far.fls"));
  EXPECT_TRUE(server.readLine().starts_with("serving formula"));
}

}  // namespace
}  // namespace foreland::test
