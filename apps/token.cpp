// `foreland token`: signs a bearer token for viewers of servers with the same secret (--token-secret), and prints it.
// Exit code 0, or 2 if an option or the secret will not do. One thread.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "apps/options.h"
#include "base/printable.h"
#include "server/net/token.h"

int main(int argc, char** argv) {
  using namespace foreland;
  std::filesystem::path secret_file;
  server::Token token{.name = "viewer"};
  double hours = 24;
  CLI::App app("Make a token with which viewers may connect to servers that ask for one.", "foreland token");
  app.add_option("--secret", secret_file, "file of the servers' secret (--token-secret)")->required();
  app.add_option("--name", token.name, "whose it is; limits hold for all tokens of one name together")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (name.size() > 200) return "at most 200 bytes";
            return isUtf8(name) ? "" : "must be UTF-8";
          },
          "", "name"))
      ->capture_default_str();
  app.add_option("--hours", hours, "until it expires")
      ->check(CLI::Range(0.001, 876'000.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--viewers", token.viewers, "at once, on each server (default 0: any number)")
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--nodes", token.section_nodes, "in the section of each viewer (default 0: the server's limit)")
      ->check(CLI::Range(0, 1'000'000'000));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) { return app.exit(error) == 0 ? 0 : 2; }
  const auto secret = server::readTokenSecret(secret_file);
  if (!secret) {
    std::fprintf(stderr, "foreland token: %s\n", secret.error().message.c_str());
    return 2;
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  token.expires_s = std::chrono::duration_cast<std::chrono::seconds>(now).count() + std::llround(3600 * hours);
  std::puts(server::signToken(token, *secret).c_str());
  return 0;
}
