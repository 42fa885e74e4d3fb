// What a viewer-hour costs.
#include "lab/cost.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/apps/expect_refusal.h"
#include "tests/support/files.h"

namespace foreland::lab {
namespace {

using Json = nlohmann::ordered_json;

// 36 s of flight: an hour is a hundred of them.
Json results() {
  Json ours{{"way", "foreland"}, {"asked_px", 1}, {"rms_px", 0.2}},
      tiles{{"way", "draco"}, {"asked_px", 3}, {"rms_px", 0.2}};
  ours.update({{"bytes", 3'000'000}, {"bytes_in_flight", 1'000'000}, {"requests", 900}, {"requests_in_flight", 800}});
  ours.update({{"compute_ms", 500}, {"compute_in_flight_ms", 360}});
  tiles.update(
      {{"bytes", 30'000'000}, {"bytes_in_flight", 10'000'000}, {"requests", 300}, {"requests_in_flight", 200}});
  tiles.update({{"compute_ms", 0}, {"compute_in_flight_ms", 0}});
  return {{"experiment", "tiles"}, {"seconds", 36.0}, {"ways", {ours, tiles}}};
}

CostPrices onlyOf(double CostPrices::*price, double value) {
  CostPrices prices{.visit_minutes = 15, .processor_use = 0.5};
  prices.*price = value;
  return prices;
}

TEST(Cost, IsBytesRequestsAndProcessorTimeAtTheirPrices) {
  // A hundred flights, and four first views.
  const auto egress = viewerHours(results(), onlyOf(&CostPrices::server_egress_gb, 10));
  ASSERT_TRUE(egress.ok());
  EXPECT_NEAR((*egress)[0].mb, 108, 1e-9);
  EXPECT_NEAR((*egress)[0].cost, 1.08, 1e-12);
  EXPECT_EQ((*egress)[1].cost, 0);
  const auto cdn = viewerHours(results(), onlyOf(&CostPrices::cdn_egress_gb, 10));
  EXPECT_NEAR((*cdn)[1].cost, 10.8, 1e-12);
  const auto requests = viewerHours(results(), onlyOf(&CostPrices::cdn_million_requests, 5));
  EXPECT_NEAR((*requests)[1].requests, 20'400, 1e-9);
  EXPECT_NEAR((*requests)[1].cost, 0.102, 1e-12);
  EXPECT_EQ((*requests)[0].cost, 0);
  // 36.56 s of a processor that is used to half.
  const auto processor = viewerHours(results(), onlyOf(&CostPrices::processor_hour, 3600));
  EXPECT_NEAR((*processor)[0].processor_s, 36.56, 1e-9);
  EXPECT_NEAR((*processor)[0].cost, 73.12, 1e-9);
  EXPECT_EQ((*processor)[1].cost, 0);
}

// Every price doubled doubles every cost and changes no ratio; equal bytes at equal prices cost the same.
TEST(Cost, IsLinearInThePrices) {
  CostPrices once{.visit_minutes = 10,
                  .server_egress_gb = 0.09,
                  .processor_hour = 0.04,
                  .processor_use = 0.5,
                  .cdn_egress_gb = 0.08,
                  .cdn_million_requests = 1};
  CostPrices twice = once;
  twice.server_egress_gb *= 2, twice.processor_hour *= 2, twice.cdn_egress_gb *= 2, twice.cdn_million_requests *= 2;
  const auto a = viewerHours(results(), once), b = viewerHours(results(), twice);
  for (size_t i = 0; i < a->size(); ++i) {
    EXPECT_NEAR((*b)[i].cost, 2 * (*a)[i].cost, 1e-12);
    EXPECT_NEAR((*b)[i].over_foreland, (*a)[i].over_foreland, 1e-12);
    EXPECT_NEAR((*a)[i].cost, (*a)[i].egress + (*a)[i].requests_cost + (*a)[i].processor, 1e-15);
  }
  EXPECT_EQ((*a)[0].over_foreland, 1);
}

TEST(Cost, RefusesOtherResultsByName) {
  const auto refusal = [](const Json& json) {
    const auto hours = viewerHours(json, {});
    return hours.ok() ? std::string() : hours.error().message;
  };
  Json old = results();
  old["ways"][1].erase("compute_ms");
  EXPECT_NE(refusal(old).find("'compute_ms'"), std::string::npos) << refusal(old);
  EXPECT_NE(refusal({{"experiment", "load"}}).find("bench tiles"), std::string::npos);
  EXPECT_NE(refusal(Json::array()).find("bench tiles"), std::string::npos);
}

TEST(Cost, TakesPricesFromAFileAndRefusesWrongOnesByName) {
  test::TemporaryFolder folder;
  std::ofstream(folder / "results.json") << results();
  const std::string path = folder / "prices.toml";
  const auto priced = [&](const std::string& use) {
    std::ofstream(path) << "visit_minutes = 15\n[server]\negress_gb = 10\nprocessor_hour = 3600\nprocessor_use = "
                        << use << "\n[cdn]\negress_gb = 10\nmillion_requests = 5\n";
    return std::vector<std::string>{"cost", folder / "", "--prices", path, "--json"};
  };
  const test::ProgramResult result = test::runProgram("bench", priced("0.5"));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Json report = Json::parse(result.output);
  EXPECT_NEAR(report["viewer_hours"][0]["cost"].get<double>(), 1.08 + 73.12, 1e-9);
  EXPECT_NEAR(report["viewer_hours"][1]["cost"].get<double>(), 10.8 + 0.102, 1e-9);
  test::expectRefusal("bench", priced("0"), {"prices.toml", "server.processor_use must be a number from 0.01 to 1"});
  test::expectRefusal("bench", priced("'much'"), {"server.processor_use"});
  test::expectRefusal("bench", priced("=,"), {"prices.toml:5"});
  test::expectRefusal("bench", {"cost", folder / "none"}, {"none"});
}

}  // namespace
}  // namespace foreland::lab
