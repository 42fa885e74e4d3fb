// A server as one opens it to the world: TLS, tokens, a configuration file, as in docs/PUBLIC_PORT.md.
#include <gtest/gtest.h>
#include <sys/un.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "terrain/pipeline/build.h"
#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

// Runs a command of the system in the shell.
int shell(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()); }

class PublicPort : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(65, 65, hills(1));
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "land.fls", 0.1, 1}).ok());
    std::ofstream(folder_ / "secret") << std::string(40, 'k') << "\n";
    makeCertificate("first");
  }
  void makeCertificate(const std::string& name) const {
    ASSERT_EQ(shell("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=" +
                    name + " -addext subjectAltName=IP:127.0.0.1 -keyout " + (folder_ / "key.pem").string() + " -out " +
                    (folder_ / "cert.pem").string()),
              0);
  }
  std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {folder_ / "land.fls", "--listen", "127.0.0.1:0"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::vector<std::string> tls() const {
    return {"--tls-cert", folder_ / "cert.pem", "--tls-key", folder_ / "key.pem"};
  }
  static ProgramResult fly(const std::string& url, std::vector<std::string> more = {}) {
    std::vector<std::string> all = {url, "--tour", "orbit", "--seconds", "1", "--viewport", "320x240"};
    all.insert(all.end(), more.begin(), more.end());
    return runProgram("fly", all);
  }
  std::string token(std::vector<std::string> more = {}) const {
    std::vector<std::string> all = {"--secret", folder_ / "secret"};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult made = runProgram("token", all);
    EXPECT_EQ(made.exit_code, 0) << made.output;
    return made.output.substr(0, made.output.find('\n'));
  }
  static bool says(const ProgramResult& result, const std::string& words) {
    return result.output.find(words) != std::string::npos;
  }

  TemporaryFolder folder_;
};

TEST_F(PublicPort, SpeaksTlsWithACertificateThatViewersCheck) {
  Program server("serve", arguments(tls()));
  const std::string line = [&] {
    std::string next = server.readLine();
    while (!next.empty() && !next.starts_with("serving")) next = server.readLine();
    return next;
  }();
  ASSERT_NE(line.find("https://127.0.0.1:"), std::string::npos) << line;
  const std::string address = "127.0.0.1:" + std::to_string(portOf(line));
  const ProgramResult flown = fly("wss://" + address, {"--ca", folder_ / "cert.pem"});
  EXPECT_EQ(flown.exit_code, 0) << flown.output;
  const ProgramResult distrusted = fly("https://" + address);
  EXPECT_EQ(distrusted.exit_code, 2);
  EXPECT_TRUE(says(distrusted, "--ca")) << distrusted.output;
  EXPECT_EQ(fly("ws://" + address).exit_code, 2) << "in the clear";
  EXPECT_EQ(fly("wss://localhost:" + std::to_string(portOf(line)), {"--ca", folder_ / "cert.pem"}).exit_code, 2)
      << "a certificate of another name";
}

TEST_F(PublicPort, ReadsItsCertificateAgainOnSighup) {
  std::filesystem::copy_file(folder_ / "cert.pem", folder_ / "old.pem");
  Program server("serve", arguments(tls()));
  std::string line = server.readLine();
  while (!line.empty() && !line.starts_with("serving")) line = server.readLine();
  const std::string url = "wss://127.0.0.1:" + std::to_string(portOf(line));
  const auto signalAndWait = [&](const std::string& words) {
    server.signal(SIGHUP);
    std::string said = server.readLine();
    while (!said.empty() && said.find(words) == std::string::npos) said = server.readLine();
    return !said.empty();
  };
  std::ofstream(folder_ / "cert.pem") << "nonsense";
  EXPECT_TRUE(signalAndWait("kept the certificate"));
  EXPECT_EQ(fly(url, {"--ca", folder_ / "old.pem"}).exit_code, 0);
  makeCertificate("second");
  EXPECT_TRUE(signalAndWait("read the certificate again"));
  EXPECT_EQ(fly(url, {"--ca", folder_ / "cert.pem"}).exit_code, 0);
  EXPECT_EQ(fly(url, {"--ca", folder_ / "old.pem"}).exit_code, 2);
}

TEST_F(PublicPort, LetsInWhoHasAToken) {
  Program server("serve", arguments({"--token-secret", folder_ / "secret", "--log-level", "off"}));
  const uint16_t port = portOf(server.readLine());
  const std::string url = "ws://127.0.0.1:" + std::to_string(port);
  const ProgramResult without = fly(url);
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_TRUE(says(without, "--token")) << without.output;
  const ProgramResult with = fly(url, {"--token", token({"--name", "a", "--viewers", "1"})});
  EXPECT_EQ(with.exit_code, 0) << with.output;
  EXPECT_EQ(metric(port, "refusals_total{reason=\"token\"}"), 1);
  EXPECT_TRUE(httpGet(port, "/livez").starts_with("HTTP/1.1 200")) << "what operators ask needs none";
}

TEST_F(PublicPort, TakesItsOptionsFromAFile) {
  const ProgramResult printed =
      runProgram("serve", arguments({"--tau", "2.5", "--allow-origin", "https://a.example", "--allow-origin",
                                     "https://b.example", "--print-config"}));
  EXPECT_EQ(printed.exit_code, 0);
  std::ofstream(folder_ / "serve.toml") << printed.output;
  const ProgramResult again = runProgram("serve", {"--config", folder_ / "serve.toml", "--print-config"});
  EXPECT_EQ(again.output, printed.output) << "the file has the same options";
  EXPECT_TRUE(says(again, "tau = 2.5")) << again.output;
  const ProgramResult won = runProgram("serve", {"--config", folder_ / "serve.toml", "--tau", "3", "--print-config"});
  EXPECT_TRUE(says(won, "tau = 3")) << "the command line wins";
}

// The options of a printed configuration that are something: what stands before and after each first equals sign.
std::map<std::string, std::string> optionsOf(const std::string& text) {
  std::map<std::string, std::string> options;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::erase(line, ' ');
    const size_t equals = line.find('=');
    if (equals == std::string::npos || line.starts_with('#')) continue;
    const std::string value = line.substr(equals + 1);
    if (value != "\"\"" && value != "[]") options[line.substr(0, equals)] = value;
  }
  return options;
}

// Each option that the shipped file comments out, put in force: the server knows it, and if the option has a value
// anyway, it is the one that the file states.
TEST_F(PublicPort, ItsShippedFileNamesOptionsAndTheirDefaults) {
  std::ifstream shipped(FORELAND_SOURCE_DIR "/deploy/serve.toml");
  ASSERT_TRUE(shipped);
  std::string in_force;
  for (std::string line; std::getline(shipped, line);)
    if (line.starts_with('#') && !line.starts_with("# ") && !line.starts_with("#:")) in_force += line.substr(1) + "\n";
  std::ofstream(folder_ / "serve.toml") << in_force;
  const ProgramResult taken = runProgram("serve", {"--config", folder_ / "serve.toml", "--print-config"});
  ASSERT_EQ(taken.exit_code, 0) << taken.output;
  const auto stated = optionsOf(in_force);
  auto defaults = optionsOf(runProgram("serve", {"x.fls", "--print-config"}).output);
  defaults.erase("SCENE");
  EXPECT_GT(stated.size(), 10u);
  size_t compared = 0;
  for (const auto& [name, value] : stated) {
    if (!defaults.contains(name)) continue;
    EXPECT_EQ(value, defaults[name]) << name;
    ++compared;
  }
  EXPECT_GT(compared, 5u);
}

TEST_F(PublicPort, RefusesFilesAndFlagsByName) {
  const auto expectRefusal = [&](const std::string& config, const std::string& words) {
    std::ofstream(folder_ / "bad.toml") << config;
    const ProgramResult result = runProgram("serve", arguments({"--config", folder_ / "bad.toml"}));
    EXPECT_EQ(result.exit_code, 2) << config;
    EXPECT_TRUE(says(result, words)) << result.output;
  };
  expectRefusal("wings = 2\n", "wings");
  expectRefusal("tau = \n", "line 1");
  expectRefusal("\ntau = 2020-01-01\n", "line 2");
  expectRefusal("tau = 0\n", "--tau");
  expectRefusal("[net]\ntau = 1\n", "net");
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{"--allow-origin", "here"},
                                             {"--trusted-proxy", "proxy"},
                                             {"--tls-cert", folder_ / "cert.pem"},
                                             {"--tls-cert", folder_ / "key.pem", "--tls-key", folder_ / "key.pem"},
                                             {"--token-secret", folder_ / "none"},
                                             {"--log", "xml"},
                                             {"--config", folder_ / "none.toml"}}) {
    const ProgramResult result = runProgram("serve", arguments(bad));
    EXPECT_EQ(result.exit_code, 2) << bad[0];
    EXPECT_TRUE(says(result, bad[0]) || says(result, bad[1])) << result.output;
  }
}

// systemd passes on the default of a credential whose file is missing; nobody can sign tokens with it.
TEST_F(PublicPort, ItsUnitNeedsNeitherKeyNorSecret) {
  std::ifstream unit(FORELAND_SOURCE_DIR "/deploy/foreland.service");
  ASSERT_TRUE(unit);
  std::map<std::string, std::string> defaults;
  std::vector<std::string> loaded;
  for (std::string line; std::getline(unit, line);) {
    const size_t equals = line.find('='), colon = line.find(':');
    const std::string id = colon == std::string::npos ? "" : line.substr(equals + 1, colon - equals - 1);
    if (line.starts_with("LoadCredential=")) loaded.push_back(id);
    if (line.starts_with("SetCredential=")) defaults[id] = line.substr(colon + 1);
  }
  EXPECT_EQ(loaded, (std::vector<std::string>{"key.pem", "secret"}));
  for (const std::string& id : loaded) {
    ASSERT_FALSE(defaults[id].empty()) << id;
    std::ofstream(folder_ / id) << defaults[id];
  }
  for (std::vector<std::string> flags : {std::vector<std::string>{"--token-secret", folder_ / "secret"}, tls()}) {
    flags.insert(flags.end(), {"--log-level", "off"});
    Program server("serve", arguments(flags));
    EXPECT_TRUE(server.readLine().starts_with("foreland serve: ")) << flags[0];
  }
}

TEST_F(PublicPort, TellsSystemdWhenItIsReadyAndWhenItStops) {
  const std::string path = folder_ / "notify";
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  Program server("serve", arguments({"--log-level", "off"}));
  ::unsetenv("NOTIFY_SOCKET");
  const auto receive = [&] {
    pollfd ready{fd, POLLIN, 0};
    char text[64] = {};
    return ::poll(&ready, 1, 20'000) > 0 && ::recv(fd, text, sizeof(text) - 1, 0) > 0 ? std::string(text) : "";
  };
  EXPECT_EQ(receive(), "READY=1");
  server.signal(SIGTERM);
  EXPECT_EQ(receive(), "STOPPING=1");
  EXPECT_EQ(server.wait(), 0);
  ::close(fd);
}

TEST_F(PublicPort, LogsJson) {
  Program server("serve", arguments({"--log", "json", "--log-level", "info"}));
  std::string line = server.readLine();
  while (!line.empty() && !line.starts_with("serving")) line = server.readLine();
  { WebSocketClient viewer(portOf(line)); }
  line = server.readLine();
  EXPECT_TRUE(line.starts_with(R"({"time":"20)")) << line;
  EXPECT_NE(line.find(R"(,"level":"info","message":"viewer 127.0.0.1:)"), std::string::npos) << line;
}

}  // namespace
}  // namespace foreland::test
