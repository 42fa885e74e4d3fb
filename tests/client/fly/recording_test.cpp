// Recordings: what is read is what was written, wherever the file ends; any other bytes end in an Error or in a flight
// that can be replayed.
#include "client/fly/recording.h"

#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>
#include <iterator>

#include "base/rng.h"
#include "client/fly/options_json.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::client {
namespace {

using test::TemporaryFolder;

Bytes readBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void writeBytes(const std::filesystem::path& path, ByteSpan bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

PlayerOptions anyOptions(Rng& rng) {
  PlayerOptions o;
  o.request.lens = {rng.uniform(0.1, 2), 1 + static_cast<uint32_t>(rng.below(4000)), 1080};
  o.request.tau_px = rng.uniform(0.1, 9);
  o.request.strategy = static_cast<proto::Strategy>(rng.below(3));
  o.request.predictor = static_cast<proto::Predictor>(rng.below(4));
  o.request.keyframe_interval = Duration{static_cast<int64_t>(rng.below(1'000'000))};
  o.request.longest_interval = Duration{static_cast<int64_t>(rng.below(1'000'000))};
  o.request.memory_bytes = static_cast<uint32_t>(rng.next());
  o.request.occlusion = rng.below(2) == 0;
  o.blend = rng.below(2) == 0 ? Blend::kKeyframe : Blend::kGeomorph;
  o.is_steered = rng.below(2) == 0;
  if (o.is_steered) return o;
  o.knowledge = rng.below(2) == 0 ? PathKnowledge::kAnnounced : PathKnowledge::kPrivate;
  o.tour = rng.below(2) == 0 ? "canyon" : "\"\\\xff";
  o.seconds = rng.uniform(1, 100);
  if (rng.below(2) == 0) o.track_options.agl_m = rng.uniform(1, 99);
  if (rng.below(2) == 0) o.track_options.seconds = rng.uniform(1, 99);
  if (rng.below(2) == 0) return o;
  Track track;
  for (int i = 0; i < 30; ++i) track.fixes.push_back({i + rng.uniform(0, 0.9), rng.uniform(-1, 1), 0.1, -7});
  track.heights = rng.below(2) == 0 ? TrackHeights::kRecorded : TrackHeights::kMissing;
  o.track = std::make_shared<const Track>(track);
  return o;
}

FlightLog anyLog(Rng& rng) {
  FlightLog log{anyOptions(rng), {}};
  Time now{static_cast<int64_t>(rng.below(1000)) - 500};
  for (uint64_t i = rng.below(60); i-- > 0;) {
    now.us += static_cast<int64_t>(rng.below(20'000));
    FlightLog::Entry entry{.time = now,
                           .what = static_cast<FlightLog::What>(rng.below(log.options.is_steered ? 6 : 3))};
    if (log.options.is_steered && entry.what == FlightLog::What::kFrame) entry.what = FlightLog::What::kSteered;
    if (entry.what == FlightLog::What::kMessage)
      for (uint64_t k = rng.below(300); k-- > 0;) entry.message.push_back(static_cast<uint8_t>(rng.next()));
    if (entry.what == FlightLog::What::kSteered)
      entry.pose = {{rng.uniform(-1e5, 1e5), rng.uniform(-1e5, 1e5), rng.uniform(0, 1e4)},
                    glm::angleAxis(rng.uniform(0, 6), glm::dvec3(0, 0, 1))};
    if (entry.what == FlightLog::What::kChoice) {
      ViewChoice choice;
      choice.request.tau_px = rng.uniform(0.1, 9);
      choice.blend = rng.below(2) == 0 ? Blend::kKeyframe : Blend::kGeomorph;
      entry.choice = std::make_shared<const ViewChoice>(choice);
    }
    log.entries.push_back(std::move(entry));
  }
  return log;
}

bool isSame(const FlightLog::Entry& a, const FlightLog::Entry& b) {
  if (!a.choice != !b.choice) return false;
  if (a.choice && choiceToJson(*a.choice) != choiceToJson(*b.choice)) return false;
  return a.time == b.time && a.what == b.what && a.message == b.message && a.pose.eye == b.pose.eye &&
         a.pose.orientation == b.pose.orientation;
}

// Whether `read` is the beginning of `written`.
bool isBeginning(const FlightLog& read, const FlightLog& written) {
  return optionsToJson(read.options) == optionsToJson(written.options) &&
         read.entries.size() <= written.entries.size() &&
         std::equal(read.entries.begin(), read.entries.end(), written.entries.begin(), isSame);
}

// In as many calls as it happens.
void write(const std::filesystem::path& path, const FlightLog& log, const FlightDigest::Value& shown, Rng& rng) {
  auto writer = RecordingWriter::create(path, log.options);
  ASSERT_TRUE(writer.ok());
  for (size_t n = 0; n < log.entries.size(); n += rng.below(9))
    ASSERT_TRUE(writer->append(std::span(log.entries).first(n)).ok());
  ASSERT_TRUE(writer->append(log.entries).ok());
  ASSERT_TRUE(writer->finish(shown).ok());
}

TEST(Recording, IsWhatWasWrittenWhereverItEnds) {
  Rng rng(test::randomSeed());
  const TemporaryFolder folder;
  for (int round = 0; round < 12; ++round) {
    const FlightLog log = anyLog(rng);
    const FlightDigest::Value shown{rng.next(), rng.next(), rng.next()};
    write(folder / "whole", log, shown, rng);
    const auto read = readRecording(folder / "whole");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(isBeginning(read->log, log));
    EXPECT_EQ(read->log.entries.size(), log.entries.size());
    EXPECT_EQ(read->shown, shown);

    const Bytes bytes = readBytes(folder / "whole");
    for (int i = 0; i < 20; ++i) {
      writeBytes(folder / "part", ByteSpan(bytes).first(rng.below(bytes.size())));
      const auto part = readRecording(folder / "part");
      if (!part.ok()) continue;
      EXPECT_TRUE(isBeginning(part->log, log));
      EXPECT_EQ(part->shown, std::nullopt);
    }
  }
}

TEST(Recording, OfAnyBytesCanBeReplayedOrIsRefused) {
  Rng rng(test::randomSeed());
  const TemporaryFolder folder;
  int sound = 0;
  for (int round = 0; round < 120; ++round) {
    write(folder / "changed", anyLog(rng), {}, rng);
    Bytes bytes = readBytes(folder / "changed");
    for (uint64_t i = 1 + rng.below(3); i-- > 0;) bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    writeBytes(folder / "changed", bytes);
    const auto read = readRecording(folder / "changed");
    if (!read.ok()) {
      EXPECT_NE(read.error().message.find("changed"), std::string::npos) << "the file is named";
      continue;
    }
    ++sound;
    replay(read->log, [](const Player&, Time) { return true; });
  }
  EXPECT_GT(sound, 8);
}

// A straight flight with frames at uneven times, turning about the vertical.
TEST(Recording, OfASteeredFlightTellsWhereTheCameraWas) {
  Rng rng(test::randomSeed());
  FlightLog log;
  log.options.is_steered = true;
  const auto poseAt = [](Time t) {
    return proto::Pose{{10 * t.us / 1e6, 5, 100}, glm::angleAxis(0.2 * double(t.us) / 1e6, glm::dvec3(0, 0, 1))};
  };
  for (Time now = Time::seconds(3); now < Time::seconds(9); now.us += 1000 + static_cast<int64_t>(rng.below(90'000)))
    log.entries.push_back({.time = now, .what = FlightLog::What::kSteered, .pose = poseAt(now)});
  const Replayed replayed = replay(log, [](const Player&, Time) { return true; });
  EXPECT_TRUE(replayed.status.ok());
  const proto::Path& path = replayed.player.path();
  EXPECT_EQ(path.start, log.entries.front().time);
  EXPECT_GE(path.end(), log.entries.back().time);
  for (Time t = path.start; t < log.entries.back().time - Duration::milliseconds(20); t.us += 7'777) {
    const proto::Pose pose = path.at(t), expected = poseAt(t);
    EXPECT_NEAR(glm::distance(pose.eye, expected.eye), 0, 0.03) << t.us;  // at the ends the path eases
    EXPECT_LT(proto::angleBetween(pose.orientation, expected.orientation), 1e-3) << t.us;
  }
}

TEST(Recording, NamesWhatIsWrongWithItsOptions) {
  const std::string sound = optionsToJson({});
  ASSERT_TRUE(optionsFromJson(sound).ok());
  for (const auto& [from, to, name] : {std::array<const char*, 3>{"\"tau_px\":0.0", "\"tau_px\":-1", "tau_px"},
                                       {"\"width_px\":1920", "\"width_px\":0", "width_px"},
                                       {"\"width_px\":1920", "\"width_px\":1e99", "width_px"},
                                       {"\"predict\"", "\"guess\"", "strategy"},
                                       {"\"tour\":\"survey\",", "", "tour"},
                                       {"\"seconds\":60.0", "\"seconds\":null", "seconds"}}) {
    std::string text = sound;
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from << " in " << text;
    text.replace(at, std::string(from).size(), to);
    const auto options = optionsFromJson(text);
    ASSERT_FALSE(options.ok()) << text;
    EXPECT_NE(options.error().message.find(name), std::string::npos) << options.error().message;
  }
  EXPECT_FALSE(choiceFromJson("{}").ok());
  EXPECT_FALSE(choiceFromJson("").ok());
  EXPECT_FALSE(optionsFromJson(R"({"steered": true})").ok());
  EXPECT_FALSE(optionsFromJson("[]").ok());
  EXPECT_FALSE(optionsFromJson("{").ok());
}

}  // namespace
}  // namespace foreland::client
