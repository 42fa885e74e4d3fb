// `foreland serve` as people run it: what it prints, how it ends, and what it says about a scene, flag or port that
// will not do.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "terrain/build/build.h"
#include "tests/server/net_client.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

// A running `foreland serve`, its output and errors in one pipe.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    const std::string path = fs::path(FORELAND_BIN_DIR) / "foreland-serve";
    arguments.insert(arguments.begin(), path);
    int ends[2];
    CHECK_EQ(::pipe(ends), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      ::close(ends[0]);
      std::vector<char*> words;
      for (std::string& a : arguments) words.push_back(a.data());
      words.push_back(nullptr);
      ::execv(path.c_str(), words.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    output_ = ::fdopen(ends[0], "r");
  }
  ~Program() {
    if (!ended_) ::kill(pid_, SIGKILL), wait();
    std::fclose(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // The next line; empty at the end.
  std::string readLine() {
    std::string line;
    for (int c = std::fgetc(output_); c != EOF && c != '\n'; c = std::fgetc(output_))
      line.push_back(static_cast<char>(c));
    return line;
  }
  std::string readToEnd() {
    std::string all;
    for (int c = std::fgetc(output_); c != EOF; c = std::fgetc(output_)) all.push_back(static_cast<char>(c));
    return all;
  }
  void signal(int number) { ::kill(pid_, number); }
  // The exit code, or -1 for another end.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
  std::FILE* output_ = nullptr;
};

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
    Program program(arguments);
    const std::string output = program.readToEnd();
    EXPECT_EQ(program.wait(), 2) << output;
    for (const std::string& word : words)
      EXPECT_NE(output.find(word), std::string::npos) << word << " is not in: " << output;
  }

  TemporaryFolder folder_;
};

uint16_t portOf(const std::string& line) {
  const size_t at = line.rfind(':');
  return at == std::string::npos ? uint16_t{0} : static_cast<uint16_t>(std::stoi(line.substr(at + 1)));
}

TEST_F(ServeProgram, PrintsWhereItIsAndStopsOnSignals) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Program program(arguments());
    const std::string line = program.readLine();
    ASSERT_TRUE(line.starts_with("serving formula at http://127.0.0.1:")) << line << program.readToEnd();
    WebSocketClient viewer(portOf(line));
    EXPECT_TRUE(viewer.isOpen());
    program.signal(signal);
    EXPECT_EQ(viewer.receiveClose(), 1001);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.readToEnd(), "");
  }
}

TEST_F(ServeProgram, RefusesScenesThatAreNone) {
  const fs::path empty = folder_ / "empty.fls", cut = folder_ / "cut.fls";
  std::ofstream(empty).flush();
  fs::copy_file(folder_ / "scene.fls", cut);
  fs::resize_file(cut, fs::file_size(cut) / 2);
  for (const fs::path& scene : {folder_ / "missing.fls", empty, cut, folder_.path()})
    expectRefusal({scene.string(), "--listen", "127.0.0.1:0"}, {scene.string()});
}

TEST_F(ServeProgram, RefusesFlagsThatItDoesNotKnow) {
  expectRefusal(arguments({"--wings"}), {"--wings"});
  expectRefusal(arguments({"--threads", "0"}), {"--threads"});
  expectRefusal(arguments({"--tau", "nan"}), {"--tau"});
  expectRefusal(arguments({"--keyframe-ms", "0"}), {"--keyframe-ms"});
  expectRefusal({}, {"SCENE"});
}

TEST_F(ServeProgram, RefusesAddressesAndPagesThatWillNotDo) {
  const std::string scene = folder_ / "scene.fls";
  expectRefusal({scene, "--listen", "nowhere"}, {"nowhere", "127.0.0.1:8080"});
  expectRefusal({scene, "--listen", "127.0.0.1:0", "--web", folder_ / "nothing"}, {folder_ / "nothing", "--web"});
  Program first(arguments());
  const std::string port = std::to_string(portOf(first.readLine()));
  expectRefusal({scene, "--listen", "127.0.0.1:" + port}, {port, "--listen"});
}

}  // namespace
}  // namespace foreland::test
