// What `foreland NAME ARGS...` is to do: it runs the executable beside it, or in libexec as it is installed, migrates
// every word and returns its exit code. Each test lays out a folder with a copy of `foreland` and small shell scripts
// for subcommands.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

struct ProgramResult {
  int exit_code = -1;
  std::string output;  // stdout and stderr
};

ProgramResult run(const std::string& command) {
  ProgramResult result;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return result;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) result.output.push_back(static_cast<char>(c));
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

class Dispatcher : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = fs::temp_directory_path() / "foreland_dispatcher_XXXXXX";
    root_ = mkdtemp(pattern.data());
    folder_ = root_ / "bin";
    fs::create_directory(folder_);
    fs::copy_file(fs::path(FORELAND_BIN_DIR) / "foreland", folder_ / "foreland");
  }
  void TearDown() override { fs::remove_all(root_); }

  std::string program() const { return folder_ / "foreland"; }
  void addSubcommand(const std::string& name, const std::string& body) const { addSubcommand(name, body, folder_); }
  void addInstalled(const std::string& name, const std::string& body) const {
    const fs::path libexec = root_ / "libexec" / "foreland";
    fs::create_directories(libexec);
    addSubcommand(name, body, libexec);
  }

  fs::path root_, folder_;

 private:
  static void addSubcommand(const std::string& name, const std::string& body, const fs::path& folder) {
    const fs::path path = folder / ("foreland-" + name);
    std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
    fs::permissions(path, fs::perms::owner_all);
  }
};

TEST_F(Dispatcher, HandsOverEveryWord) {
  addSubcommand("build", R"(for word in "$@"; do echo "[$word]"; done)");
  const ProgramResult result = run(program() + " build 'two words' --flag '' '*' -o x.fls");
  EXPECT_EQ(result.output, "[two words]\n[--flag]\n[]\n[*]\n[-o]\n[x.fls]\n");
  EXPECT_EQ(result.exit_code, 0);
}

TEST_F(Dispatcher, ReturnsTheExitCodeOfTheSubcommand) {
  addSubcommand("verify", "exit 37");
  EXPECT_EQ(run(program() + " verify scene.fls").exit_code, 37);
}

TEST_F(Dispatcher, FindsSubcommandsBesideItThroughALink) {
  addSubcommand("info", "echo found");
  fs::create_directory(folder_ / "elsewhere");
  fs::create_symlink(folder_ / "foreland", folder_ / "elsewhere" / "foreland");
  EXPECT_EQ(run("cd / && " + (folder_ / "elsewhere" / "foreland").string() + " info").output, "found\n");
}

TEST_F(Dispatcher, FindsInstalledSubcommandsFromWherever) {
  addInstalled("info", R"(echo "installed: $*")");
  EXPECT_EQ(run("cd / && " + program() + " info a.fls").output, "installed: a.fls\n");
  fs::create_symlink(program(), root_ / "link");
  EXPECT_EQ(run((root_ / "link").string() + " help info").output, "installed: --help\n");
}

TEST_F(Dispatcher, PrefersASubcommandBesideIt) {
  addInstalled("info", "echo installed");
  addSubcommand("info", "echo beside");
  EXPECT_EQ(run(program() + " info").output, "beside\n");
}

TEST_F(Dispatcher, SaysHowToGetTheLaboratory) {
  for (const char* words : {"bench", "link", "bench sections x.fls", "help bench"}) {
    const ProgramResult result = run(program() + " " + words);
    EXPECT_EQ(result.exit_code, 2) << words;
    EXPECT_NE(result.output.find("install the package foreland-lab"), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("FORELAND_LAB=ON"), std::string::npos) << result.output;
  }
  addInstalled("bench", "echo measured");
  EXPECT_EQ(run(program() + " bench").output, "measured\n");
}

TEST_F(Dispatcher, HelpOfASubcommandIsTheSubcommandsOwn) {
  addSubcommand("fly", R"(echo "fly: $*")");
  EXPECT_EQ(run(program() + " help fly").output, "fly: --help\n");
}

TEST_F(Dispatcher, HelpListsTheSubcommands) {
  for (const char* words : {"", " help", " --help", " -h"}) {
    const ProgramResult result = run(program() + words);
    EXPECT_EQ(result.exit_code, 0) << words;
    for (const char* name : {"build", "synth", "info", "verify", "serve", "fly", "bench"})
      EXPECT_NE(result.output.find(std::string("\n  ") + name + " "), std::string::npos) << words << ": " << name;
  }
}

TEST_F(Dispatcher, PrintsItsVersion) { EXPECT_TRUE(run(program() + " --version").output.starts_with("foreland ")); }

TEST_F(Dispatcher, RefusesWhatIsNotThereWithTheList) {
  for (const char* words : {"biuld", "--flag", "''", "../foreland-build", "build/../build", "help biuld"}) {
    const ProgramResult result = run(program() + " " + words);
    EXPECT_EQ(result.exit_code, 2) << words;
    EXPECT_NE(result.output.find("usage: foreland SUBCOMMAND"), std::string::npos) << words;
  }
}

TEST_F(Dispatcher, NamesAnExecutableThatCannotBeRun) {
  std::ofstream(folder_ / "foreland-serve") << "not executable";
  const ProgramResult result = run(program() + " serve");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.output.find("foreland-serve"), std::string::npos);
}

}  // namespace
}  // namespace foreland::test
