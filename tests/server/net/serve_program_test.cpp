// `foreland serve` as people run it: what it prints, how it ends, and what it says about a scene, flag or port that
// will not do.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "proto/message/message.h"
#include "terrain/pipeline/build.h"
#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

class ServeProgram : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(65, 65, hills(1));
    const auto report = terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1});
    ASSERT_TRUE(report.ok()) << report.error().message;
    fs::create_directory(folder_ / "web");
    std::ofstream(folder_ / "web/index.html") << "<html>";
  }
  std::vector<std::string> arguments(std::vector<std::string> more = {}) const {
    std::vector<std::string> all = {folder_ / "scene.fls", "--listen",    "127.0.0.1:0", "--web",
                                    folder_ / "web",       "--log-level", "off"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  // Exit code 2, and a message that holds each of `words`.
  static void expectRefusal(const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    const ProgramResult result = runProgram("serve", arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    for (const std::string& word : words)
      EXPECT_NE(result.output.find(word), std::string::npos) << word << " is not in: " << result.output;
  }

  TemporaryFolder folder_;
};

TEST_F(ServeProgram, PrintsWhereItIsAndStopsOnSignals) {
  for (const auto& [signal, close_code] : {std::pair(SIGTERM, 1012), std::pair(SIGINT, 1001)}) {
    Program program("serve", arguments());
    const std::string line = program.readLine();
    ASSERT_TRUE(line.starts_with("serving formula at http://127.0.0.1:")) << line << program.readToEnd();
    WebSocketClient viewer(portOf(line));
    EXPECT_TRUE(viewer.isOpen());
    program.signal(signal);
    EXPECT_EQ(viewer.receiveClose(), close_code);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.readToEnd(), "");
  }
}

TEST_F(ServeProgram, PrintsWhereItsMetricsAre) {
  Program program("serve", arguments({"--metrics-listen", "127.0.0.1:0"}));
  ASSERT_TRUE(program.readLine().starts_with("serving "));
  const std::string line = program.readLine();
  ASSERT_TRUE(line.starts_with("metrics at http://127.0.0.1:")) << line;
  EXPECT_EQ(metric(portOf(line), "sessions"), 0);
}

// Its viewer does not answer, so it would wait for that.
TEST_F(ServeProgram, EndsAtOnceOnASecondSignal) {
  Program program("serve", arguments({"--drain-seconds", "3600"}));
  const uint16_t port = portOf(program.readLine());
  WebSocketClient viewer(port);
  ASSERT_TRUE(viewer.isOpen());
  program.signal(SIGTERM);
  EXPECT_EQ(viewer.receiveClose(), 1012);
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), -1);
}

// Who reloads certificates every night need not look whether a server stops.
TEST_F(ServeProgram, HandsItsViewersOverInSpiteOfSighup) {
  Program program("serve", arguments({"--drain-seconds", "3600"}));
  WebSocketClient viewer(portOf(program.readLine()));
  ASSERT_TRUE(viewer.isOpen());
  program.signal(SIGTERM);
  EXPECT_EQ(viewer.receiveClose(), 1012);
  program.signal(SIGHUP);
  viewer.sendFrame(Opcode::kClose, std::string("\x03\xf4", 2));
  EXPECT_EQ(program.wait(), 0);
}

double residentBytes(uint16_t port) {
  const std::string page = httpGet(port, "/metrics"), name = "\nprocess_resident_memory_bytes ";
  const size_t at = page.find(name);
  return at == std::string::npos ? 0 : std::stod(page.substr(at + name.size()));
}

// Flies so many viewers at once, until they have left.
void visit(uint16_t port, int viewers) {
  const ProgramResult flights =
      runProgram("fly", {"ws://127.0.0.1:" + std::to_string(port), "--viewers", std::to_string(viewers), "--tour",
                         "survey", "--tau", "0.1", "--seconds", "2"});
  EXPECT_EQ(flights.exit_code, 0) << flights.output;
  EXPECT_TRUE(eventually([&] { return metric(port, "sessions") == 0; }));
}

TEST_F(ServeProgram, GivesMemoryBackWhenViewersLeave) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer keeps what is given up";
  FormulaSource source(513, 513, hills(2));
  ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  Program server("serve", arguments());
  const uint16_t port = portOf(server.readLine());
  visit(port, 2);  // for what a server keeps: the scene's pages, the workers' scratch
  const double before = residentBytes(port);
  visit(port, 40);
  // What the system keeps: a busy server that is asked again and again might show but its quiet moments.
  const double most = 1024.0 * static_cast<double>(server.kibibytes("VmHWM"));
  EXPECT_GT(most, before + (16 << 20));
  double after = 0;
  EXPECT_TRUE(eventually([&] { return (after = residentBytes(port)) < before + 0.25 * (most - before); }))
      << before << " bytes, then " << most << ", then " << after;
}

TEST_F(ServeProgram, RefusesScenesThatAreNone) {
  const fs::path empty = folder_ / "empty.fls", cut = folder_ / "cut.fls";
  std::ofstream(empty).flush();
  fs::copy_file(folder_ / "scene.fls", cut);
  fs::resize_file(cut, fs::file_size(cut) / 2);
  for (const fs::path& scene : {folder_ / "missing.fls", empty, cut, folder_.path()})
    expectRefusal({scene.string(), "--listen", "127.0.0.1:0"}, {scene.string()});
}

TEST_F(ServeProgram, RefusesASceneWithAFlippedByte) {
  const fs::path flipped = folder_ / "flipped.fls";
  fs::copy_file(folder_ / "scene.fls", flipped);
  std::fstream file(flipped, std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(fs::file_size(flipped) / 2);
  file.seekg(middle);
  const char byte = static_cast<char>(file.get() ^ 1);
  file.seekp(middle);
  file.put(byte);
  file.close();
  expectRefusal({flipped, "--listen", "127.0.0.1:0"}, {flipped, "block", "build or copy the scene again"});
}

// Someone copies another file over the scene that is being served, say.
TEST_F(ServeProgram, NamesASceneThatIsCutShortWhileItIsServed) {
  Program server("serve", arguments());
  const uint16_t port = portOf(server.readLine());
  fs::resize_file(folder_ / "scene.fls", 4096);
  WebSocketClient client(port);
  client.send(proto::encode(proto::ViewRequest{}));
  proto::PoseUpdate update{{Time::seconds(1), {{0, 0, 1500}, proto::lookAlong({0, 0, -1}, {0, 0, 1})}}, 0, {}};
  client.send(proto::encode(update));
  const std::string output = server.readToEnd();
  EXPECT_EQ(server.wait(), 3) << output;
  EXPECT_NE(output.find(folder_ / "scene.fls"), std::string::npos) << output;
  EXPECT_NE(output.find("cut short"), std::string::npos) << output;
}

TEST_F(ServeProgram, RefusesFlagsThatItDoesNotKnow) {
  expectRefusal(arguments({"--wings"}), {"--wings"});
  expectRefusal(arguments({"--threads", "1025"}), {"--threads"});
  expectRefusal(arguments({"--tau", "nan"}), {"--tau"});
  expectRefusal(arguments({"--keyframe-ms", "0"}), {"--keyframe-ms"});
  expectRefusal(arguments({"--drain-seconds", "-1"}), {"--drain-seconds"});
  expectRefusal(arguments({"--max-section-nodes", "999"}), {"--max-section-nodes", "1000"});
  expectRefusal(arguments({"--queue-mib", "0.5"}), {"--queue-mib", "4096"});
  expectRefusal(arguments({"--idle-seconds", "0"}), {"--idle-seconds", "3600"});
  expectRefusal({}, {"SCENE"});
}

TEST_F(ServeProgram, KeepsTheLimitsThatItIsGiven) {
  Program server("serve", arguments({"--max-section-nodes", "1000", "--queue-mib", "1"}));
  const uint16_t port = portOf(server.readLine());
  WebSocketClient viewer(port), flood(port);
  proto::ViewRequest fine;
  fine.tau_px = 0.01;
  proto::PoseUpdate update{{Time::seconds(1), {{0, 0, 1500}, proto::lookAlong({0, 0, -1}, {0, 0, 1})}}, 0, {}};
  viewer.send(proto::encode(fine));
  viewer.send(proto::encode(update));
  ASSERT_TRUE(viewer.receive() && viewer.receive()) << "a welcome and a keyframe";
  EXPECT_GT(metric(port, "section_nodes"), 500);
  EXPECT_LE(metric(port, "section_nodes"), 1000);
  flood.send(Bytes((1u << 20) + 1));
  EXPECT_EQ(flood.receiveClose(), 1008);
}

// Sooner than the default, which is longer than a test waits.
TEST_F(ServeProgram, DisconnectsWhoIsIdleForAsLongAsItIsTold) {
  Program server("serve", arguments({"--idle-seconds", "1"}));
  WebSocketClient viewer(portOf(server.readLine()));
  viewer.send(proto::encode(proto::ViewRequest{}));
  EXPECT_EQ(viewer.receiveClose(), 1008);
}

TEST_F(ServeProgram, RefusesAddressesAndPagesThatWillNotDo) {
  const std::string scene = folder_ / "scene.fls";
  expectRefusal({scene, "--listen", "nowhere"}, {"nowhere", "127.0.0.1:8080"});
  expectRefusal({scene, "--listen", "127.0.0.1:0", "--web", folder_ / "nothing"}, {folder_ / "nothing", "--web"});
  expectRefusal(arguments({"--metrics-listen", "nowhere"}), {"nowhere", "--metrics-listen"});
  Program first("serve", arguments());
  const std::string port = std::to_string(portOf(first.readLine()));
  expectRefusal({scene, "--listen", "127.0.0.1:" + port}, {port, "--listen"});
  expectRefusal(arguments({"--metrics-listen", "127.0.0.1:" + port}), {port, "--metrics-listen"});
}

TEST_F(ServeProgram, ShowsSeveralScenesOnOnePage) {
  FormulaSource source(65, 33, hills(2));
  ASSERT_TRUE(terrain::buildScene(source, {folder_ / "alps.fls", 0.1, 1}).ok());
  std::ofstream(folder_ / "hut.geojson") << R"({"type":"Point","coordinates":[8,46]})";
  Program server("serve", arguments({folder_ / "alps.fls", "--overlay", folder_ / "hut.geojson"}));
  const std::string line = server.readLine();
  ASSERT_TRUE(line.starts_with("serving 2 scenes (scene, alps) at http://")) << line;
  const uint16_t port = portOf(line);
  const std::string list = httpGet(port, "/");
  for (const std::string name : {"scene", "alps"}) {
    EXPECT_NE(list.find("href=\"" + name + "/\""), std::string::npos) << list;
    EXPECT_NE(list.find("src=\"" + name + "/picture.png\""), std::string::npos) << list;
    const std::string picture = httpGet(port, "/" + name + "/picture.png");
    EXPECT_NE(picture.find("image/png"), std::string::npos);
    EXPECT_NE(picture.find("\x89PNG"), std::string::npos);
    EXPECT_NE(httpGet(port, "/" + name + "/overlays/list.json").find("hut.geojson"), std::string::npos);
    EXPECT_NE(httpGet(port, "/" + name + "/").find("<html>"), std::string::npos);
    EXPECT_TRUE(WebSocketClient(port, 0, "/" + name + "/fly").isOpen());
  }
  EXPECT_TRUE(httpGet(port, "/alp/").starts_with("HTTP/1.1 404"));
}

TEST_F(ServeProgram, RefusesScenesThatCannotBeToldApart) {
  const auto expectBoth = [&](const fs::path& second, const std::vector<std::string>& words) {
    expectRefusal(arguments({second}), words);
  };
  fs::create_directory(folder_ / "other");
  fs::copy_file(folder_ / "scene.fls", folder_ / "other/scene.fls");
  fs::copy_file(folder_ / "scene.fls", folder_ / "copy.fls");
  fs::copy_file(folder_ / "scene.fls", folder_ / "my scene.fls");
  fs::copy_file(folder_ / "scene.fls", folder_ / "metrics.fls");
  expectBoth(folder_ / "other/scene.fls", {"'/scene/'", "another scene", "rename"});
  expectBoth(folder_ / "copy.fls", {"'scene' and 'copy' are the same scene"});
  expectBoth(folder_ / "my scene.fls", {"'/my scene/'", "letters, digits"});
  expectBoth(folder_ / "metrics.fls", {"'/metrics/'", "itself"});
  expectBoth(folder_ / "nothing.fls", {"nothing.fls"});
}

TEST_F(ServeProgram, GivesOverlaysToPages) {
  const std::string text = R"({"type":"Point","coordinates":[8,46]})";
  std::ofstream(folder_ / "a \"hut\".geojson") << text;
  std::ofstream(folder_ / "track.GPX") << "\xef\xbb\xbf <gpx/>";
  std::ofstream(folder_ / "names.csv") << "name,lon,lat\nHut,8,46\n";
  Program server("serve", arguments({"--overlay", folder_ / "a \"hut\".geojson", "--overlay", folder_ / "track.GPX",
                                     "--overlay", folder_ / "names.csv"}));
  const uint16_t port = portOf(server.readLine());
  const std::string list = httpGet(port, "/overlays/list.json");
  EXPECT_TRUE(list.ends_with(
      R"([{"name":"a \"hut\".geojson","path":"0.geojson"},{"name":"track.GPX","path":"1.gpx"},{"name":"names.csv","path":"2.csv"}])"))
      << list;
  const std::string first = httpGet(port, "/overlays/0.geojson");
  EXPECT_TRUE(first.ends_with(text)) << first;
  EXPECT_NE(first.find("application/octet-stream"), std::string::npos) << first;  // nothing that a browser shows
  EXPECT_NE(httpGet(port, "/overlays/1.gpx").find("<gpx/>"), std::string::npos);
  EXPECT_NE(httpGet(port, "/overlays/2.csv").find("Hut,8,46"), std::string::npos);
  Program without("serve", arguments());
  EXPECT_TRUE(httpGet(portOf(without.readLine()), "/overlays/list.json").ends_with("[]"));
}

TEST_F(ServeProgram, RefusesOverlaysThatWillNotDo) {
  std::ofstream(folder_ / "a.shp") << "x";
  std::ofstream(folder_ / "a.kml") << "hello";
  std::ofstream(folder_ / "empty.gpx");
  std::ofstream(folder_ / "huge.geojson") << "{";
  fs::resize_file(folder_ / "huge.geojson", (64u << 20) + 1);
  expectRefusal(arguments({"--overlay", folder_ / "none.kml"}), {"none.kml", "no such file"});
  expectRefusal(arguments({"--overlay", folder_ / "a.shp"}), {"a.shp", "ogr2ogr -f GeoJSON"});
  expectRefusal(arguments({"--overlay", folder_ / "a.kml"}), {"a.kml", "begins with <"});
  expectRefusal(arguments({"--overlay", folder_ / "empty.gpx"}), {"empty.gpx", "begins with <"});
  std::ofstream(folder_ / "empty.csv") << " \n";
  expectRefusal(arguments({"--overlay", folder_ / "empty.csv"}), {"empty.csv", "it is empty"});
  expectRefusal(arguments({"--overlay", folder_ / "huge.geojson"}), {"huge.geojson", "64 MiB", "-simplify"});
}

// Started where few files may be open, as by a shell, it may still take as many connections as it says.
TEST_F(ServeProgram, AllowsItselfAsManyDescriptorsAsItsConnectionsNeed) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_GE(before.rlim_max, 1200u);
  const rlimit few{200, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  Program program("serve", arguments({"--max-connections", "1000"}));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  const uint16_t port = portOf(program.readLine());
  const std::string page = httpGet(port, "/metrics"), name = "\nprocess_max_fds ";
  const size_t at = page.find(name);
  ASSERT_NE(at, std::string::npos) << page;
  EXPECT_GE(std::stod(page.substr(at + name.size())), 1000);
}

}  // namespace
}  // namespace foreland::test
