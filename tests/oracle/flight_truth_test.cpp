#include "oracle/flight_truth.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <string>
#include <type_traits>

#include "tests/oracle/virtual_flight.h"

namespace foreland::oracle {
namespace {

// Every figure, by name, to the bit.
template <class Figures>
void collect(const Figures& figures, const std::string& prefix, std::map<std::string, uint64_t>& out) {
  figures.fields([&](const char* name, const auto& value) {
    if constexpr (requires { value.fields([](const char*, const auto&) {}); })
      collect(value, prefix + name + ".", out);
    else if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>)
      out[prefix + name] = std::bit_cast<uint64_t>(static_cast<double>(value));
  });
}

TEST(FlightTruth, IsTheSameToTheBitForAnyNumberOfThreads) {
  for (const proto::Strategy strategy : {proto::Strategy::kPredict, proto::Strategy::kCurrent}) {
    client::PlayerOptions options = tourOptions(strategy);
    options.tour = "orbit";
    options.seconds = 2;
    const server::SceneObjects objects = test::objectsIn(*alps(), 4);
    const Flight flight = flown(options, test::objectsIn(*alps(), 4));
    std::map<std::string, uint64_t> of_one;
    for (const unsigned threads : {1u, 2u, 5u}) {
      const FlightTruth truth = measured(
          flight.player, {.frame_every = 5, .sections = apps::exactSectionsOf(alps()), .threads = threads}, objects);
      std::map<std::string, uint64_t> figures;
      collect(truth, "", figures);
      EXPECT_GT(truth.interpolation.count, 15u);
      EXPECT_GT(figures.size(), 40u);
      if (threads == 1) of_one = figures;
      EXPECT_EQ(figures, of_one) << threads << " threads, " << proto::name(strategy);
    }
  }
}

TEST(FlightTruth, OfAFewFramesIsOfTheWholeFlight) {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  double last = 0;
  const FlightTruth truth = measured(flight.player, {.frame_every = 1,
                                                     .max_frames = 15,
                                                     .sections = apps::exactSectionsOf(alps()),
                                                     .terms_every = 4,
                                                     .on_progress = [&](double share) {
                                                       EXPECT_GE(share, last);
                                                       last = share;
                                                       return true;
                                                     }});
  EXPECT_TRUE(truth.is_whole);
  EXPECT_GT(truth.frames.count, 8u);
  EXPECT_LE(truth.frames.count, 15u);
  EXPECT_GT(truth.keyframes.count, 6u);
  EXPECT_LE(truth.keyframes.count, 15u);
  EXPECT_EQ(truth.interpolation.count, (truth.frames.count + 3) / 4);
  EXPECT_EQ(truth.extrapolation.count, (truth.keyframes.count + 3) / 4);
  EXPECT_EQ(truth.weights_judged.distinct(), truth.frames.count);
  EXPECT_GT(last, 0.9);
  EXPECT_LE(last, 1);
}

TEST(FlightTruth, OfAFlightWithoutTermsHasNone) {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  const FlightTruth truth =
      measured(flight.player, {.frame_every = 20, .sections = apps::exactSectionsOf(alps()), .terms_every = 0});
  EXPECT_FALSE(truth.has_terms);
  EXPECT_EQ(truth.interpolation.count + truth.extrapolation.count, 0u);
  EXPECT_GT(truth.frames.count, 5u);
}

TEST(FlightTruth, EndsWhenItIsToldTo) {
  const Flight flight = flown(tourOptions(proto::Strategy::kPredict));
  for (const unsigned threads : {1u, 3u}) {
    int pieces = 0;
    const FlightTruth truth = measured(
        flight.player,
        {.frame_every = 5, .sections = {}, .threads = threads, .on_progress = [&](double) { return ++pieces < 10; }});
    EXPECT_FALSE(truth.is_whole);
    EXPECT_GE(pieces, 10);
    EXPECT_LE(truth.frames.count, 16u);  // those of the pieces that were begun
    EXPECT_GT(truth.frames.max_px, 0);
  }
}

}  // namespace
}  // namespace foreland::oracle
