// The alerts and the dashboard of deploy/, with Prometheus' own checker: they parse, do what they say, and ask for
// nothing that a server does not export.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "terrain/pipeline/build.h"
#include "tests/deploy/proxy.h"
#include "tests/server/net/client.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

constexpr const char* kPromtool = "/usr/bin/promtool";  // Debian's package prometheus
const std::filesystem::path kDeploy = std::filesystem::path(FORELAND_SOURCE_DIR) / "deploy";

std::vector<std::string> dashboardQueries() {
  std::vector<std::string> queries;
  const auto dashboard = nlohmann::json::parse(std::ifstream(kDeploy / "grafana/foreland.json"));
  for (const auto& panel : dashboard["panels"])
    for (const auto& target : panel["targets"]) queries.push_back(target["expr"].get<std::string>());
  return queries;
}

class Monitoring : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::filesystem::exists(kPromtool)) << "install it: tools/install_packages.sh test";
  }
  static void expectGood(const std::vector<std::string>& arguments) {
    const ProgramResult result = runProgram(kPromtool, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }
};

TEST_F(Monitoring, AlertsDoWhatTheySay) {
  expectGood({"check", "rules", "--lint-fatal", kDeploy / "prometheus/alerts.yml"});
  expectGood({"test", "rules", kDeploy / "prometheus/alerts_test.yml"});
}

// As rules, which is how promtool takes queries without a server.
TEST_F(Monitoring, DashboardsQueriesParse) {
  const TemporaryFolder folder;
  const std::vector<std::string> queries = dashboardQueries();
  ASSERT_GE(queries.size(), 10u);
  nlohmann::json rules;
  for (size_t i = 0; i < queries.size(); ++i)
    rules.push_back({{"record", "query:" + std::to_string(i)}, {"expr", queries[i]}});
  std::ofstream(folder / "rules.yml") << nlohmann::json{{"groups", {{{"name", "dashboard"}, {"rules", rules}}}}};
  expectGood({"check", "rules", folder / "rules.yml"});
}

// By a server whose scene is in a store, which another server is.
TEST_F(Monitoring, AllThatIsAskedForIsExported) {
  const TemporaryFolder folder;
  const std::string scene = folder / "land.fls";
  FormulaSource source(65, 65, hills(1));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  ASSERT_EQ(runProgram("sums", {scene}).exit_code, 0);
  spit(folder / "index.html", {'<', 'p', '>'});
  const std::vector<std::string> options{"--listen", "127.0.0.1:0", "--log-level", "off"};
  std::vector<std::string> words{scene, "--web", folder.path().string()};
  words.insert(words.end(), options.begin(), options.end());
  Program store("serve", words);
  words = {"http://127.0.0.1:" + std::to_string(portOf(store.readLine())) + "/land.fls"};
  words.insert(words.end(), options.begin(), options.end());
  Program server("serve", words);
  const uint16_t port = portOf(server.readLine());
  const std::string page = httpGet(port, "/metrics");
  ASSERT_NE(page.find("\nforeland_pool_load "), std::string::npos) << page;
  std::string asked = textOf(kDeploy / "prometheus/alerts.yml");
  for (const std::string& query : dashboardQueries()) asked += query + "\n";
  const std::regex name("(?:foreland|process)_[a-z_]+");
  std::set<std::string> names;
  for (std::sregex_iterator it(asked.begin(), asked.end(), name), end; it != end; ++it) names.insert(it->str());
  EXPECT_GE(names.size(), 12u);
  for (const std::string& metric : names)
    EXPECT_TRUE(page.find("\n" + metric + " ") != std::string::npos ||
                page.find("\n" + metric + "{") != std::string::npos)
        << metric;
}

}  // namespace
}  // namespace foreland::test
