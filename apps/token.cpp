// `foreland token`: signs a bearer token for viewers of servers with the same secret (--token-secret), and prints it.
// Exit code 0, or 2 if an option or the secret will not do. One thread.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "base/printable.h"
#include "server/net/access/token.h"

int main(int argc, char** argv) {
  using namespace foreland;
  std::filesystem::path secret_file;
  server::Token token{.name = "viewer"};
  double hours = 24;
  CLI::App app("Makes a token with which viewers may connect to servers that ask for one.", "foreland token");
  app.add_option("--secret", secret_file, "file of the servers' secret (`foreland serve --token-secret`)")
      ->type_name(apps::file("FILE"))
      ->required();
  app.add_option("--name", token.name, "whose it is; limits hold for all tokens of one name together")
      ->type_name(apps::text("NAME"))
      ->check(CLI::Validator(
          [](std::string& name) {
            if (name.size() > 200) return "at most 200 bytes";
            return isUtf8(name) ? "" : "must be UTF-8";
          },
          "", "name"))
      ->capture_default_str();
  app.add_option("--hours", hours, "until it expires")
      ->type_name(apps::number("H"))
      ->check(apps::within(0.001, 876'000.0))
      ->capture_default_str();
  app.add_option("--viewers", token.viewers, "at once, on each server; 0: any number")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0, 1'000'000))
      ->capture_default_str();
  app.add_option("--nodes", token.section_nodes, "in the section of each viewer; 0: the server's limit")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0, 1'000'000'000))
      ->capture_default_str();
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"half a day for three viewers", "foreland token --secret secret --name kiosk --hours 12 --viewers 3"}});
  if (exit_code) return *exit_code;
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
