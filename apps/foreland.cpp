// The program `foreland`: `foreland NAME ARGS...` runs the executable foreland-NAME, as git does with its subcommands,
// so that only the programs that read foreign files are linked with the libraries that do. These lie beside it where
// they were built, and in libexec where they are installed, so that PATH has one name. The exit code is the
// subcommand's; for an unknown name it is 2, after a list of the subcommands, and also if the processor cannot run what
// was compiled: this program alone is compiled for every x86-64. One thread.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace {

constexpr int kUsageError = 2;

enum class Part : uint8_t { kProduct, kLaboratory };

struct Subcommand {
  std::string_view name;
  std::string_view summary;
  Part part = Part::kProduct;
};

constexpr std::array kSubcommands{
    Subcommand{"build", "make a scene file from elevation data"},
    Subcommand{"plan", "list the blocks of a large scene, for many machines to make"},
    Subcommand{"block", "make blocks of a plan"},
    Subcommand{"merge", "make the scene file of a plan's blocks"},
    Subcommand{"synth", "make a synthetic mountain landscape"},
    Subcommand{"remesh", "make a surface file from a polygon model"},
    Subcommand{"info", "print what a scene or surface file holds"},
    Subcommand{"verify", "check a file's checksums and invariants"},
    Subcommand{"sums", "make checksums of a scene that is to be served from a store"},
    Subcommand{"serve", "serve a scene to viewers, and the page that shows it"},
    Subcommand{"token", "make a token with which viewers may connect"},
    Subcommand{"link", "let connections to a server be as slow as over a real network", Part::kLaboratory},
    Subcommand{"fly", "fly through a served scene without a screen, and report"},
    Subcommand{"replay", "fly a recorded flight again, and report"},
    Subcommand{"render", "make reference pictures by ray casting"},
    Subcommand{"heights", "tell heights at places, above the sea and the ellipsoid"},
    Subcommand{"viewshed", "tell what is seen from a point, exactly"},
    Subcommand{"bench", "run a measurement", Part::kLaboratory},
};

void printList(Part part, std::FILE* out) {
  for (const Subcommand& subcommand : kSubcommands)
    if (subcommand.part == part) std::fprintf(out, "  %-8s %s\n", subcommand.name.data(), subcommand.summary.data());
}

void printHelp(std::FILE* out) {
  std::fputs("usage: foreland SUBCOMMAND [ARGS...]\n\n", out);
  printList(Part::kProduct, out);
  std::fputs("\nThe laboratory (package foreland-lab):\n", out);
  printList(Part::kLaboratory, out);
  std::fputs("\n`foreland help SUBCOMMAND` tells more; `foreland --version` prints the version.\n", out);
}

// For tools/make_manual.py, as the subcommands print their options. Summaries have nothing that JSON would escape.
void printAsJson() {
  std::puts("{\"name\": \"foreland\", \"version\": \"" FORELAND_VERSION "\", \"subcommands\": [");
  for (const Subcommand& subcommand : kSubcommands)
    std::printf("  {\"name\": \"%s\", \"summary\": \"%s\"}%s\n", subcommand.name.data(), subcommand.summary.data(),
                &subcommand == &kSubcommands.back() ? "" : ",");
  std::puts("]}");
}

int refuse(std::string_view what, const std::string& name) {
  std::fprintf(stderr, "foreland: %s '%s'\n\n", what.data(), name.c_str());
  printHelp(stderr);
  return kUsageError;
}

bool isName(std::string_view word) {
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  return !word.empty() && word.front() != '-' && std::all_of(word.begin(), word.end(), allowed);
}

bool isOfLaboratory(const std::string& name) {
  return std::any_of(kSubcommands.begin(), kSubcommands.end(),
                     [&](const Subcommand& s) { return s.name == name && s.part == Part::kLaboratory; });
}

int refuseMissing(const std::string& name) {
  if (!isOfLaboratory(name)) return refuse("there is no subcommand", name);
  std::fprintf(
      stderr,
      "foreland: `foreland %s` is a part of the laboratory, which is not here: install the package foreland-lab, "
      "or build with -DFORELAND_LAB=ON\n",
      name.c_str());
  return kUsageError;
}

// Beside this program, or where it is installed; the first if it is nowhere.
std::filesystem::path executableOf(const std::string& name, const std::filesystem::path& own_folder) {
  const std::filesystem::path beside = own_folder / ("foreland-" + name);
  const std::filesystem::path installed = own_folder / FORELAND_SUBCOMMANDS / ("foreland-" + name);
  std::error_code ignored;
  return !std::filesystem::exists(beside, ignored) && std::filesystem::exists(installed, ignored) ? installed : beside;
}

// Returns only if the executable cannot be run.
int execute(const std::string& program, const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  if (errno == ENOENT) return refuseMissing(name);
  std::fprintf(stderr, "foreland: cannot run %s: %s\n", program.c_str(), std::strerror(errno));
  return kUsageError;
}

int runSubcommand(const std::string& name, const std::vector<std::string>& arguments) {
  if (!isName(name)) return refuse("there is no subcommand", name);
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) {
    std::fprintf(stderr, "foreland: cannot tell where it lies (%s); is /proc mounted?\n", error.message().c_str());
    return kUsageError;
  }
  return execute(executableOf(name, self.parent_path()), name, arguments);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const bool asks_help = words.empty() || words[0] == "help" || words[0] == "--help" || words[0] == "-h";
  if (asks_help && words.size() >= 2 && words[0] == "help") return runSubcommand(words[1], {"--help"});
  if (asks_help) {
    printHelp(stdout);
    return 0;
  }
  if (words[0] == "--version") {
    std::puts("foreland " FORELAND_VERSION);
    return 0;
  }
  if (words[0] == "--options-as-json") {
    printAsJson();
    return 0;
  }
  if (words[0].starts_with('-')) return refuse("there is no option", words[0]);
  return runSubcommand(words[0], {words.begin() + 1, words.end()});
}
