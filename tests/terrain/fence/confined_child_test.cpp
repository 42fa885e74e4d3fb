// What a confined child makes comes back, and it can reach nothing but what it was given; its parent is not confined.
#include "terrain/fence/confined_child.h"

#include <gtest/gtest.h>
#include <linux/landlock.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "tests/support/files.h"

namespace foreland::terrain {
namespace {

constexpr size_t kMost = 1u << 22;

bool canRead(const std::filesystem::path& path) { return std::ifstream(path).get() != EOF; }
bool canConnect() {
  const int one = socket(AF_INET, SOCK_STREAM, 0);
  if (one >= 0) close(one);
  return one >= 0;
}

TEST(ConfinedChild, GivesBackWhatItMakes) {
  for (const size_t size : {size_t{0}, size_t{1}, size_t{3'000'000}}) {
    Bytes made(size);
    for (size_t i = 0; i < size; ++i) made[i] = static_cast<uint8_t>(i * 7 >> 3);
    const auto bytes = inConfinedChild({}, kMost, [&] { return made; });
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    EXPECT_EQ(*bytes, made);
  }
}

TEST(ConfinedChild, ReachesOnlyWhatItWasGiven) {
  if (syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) < 1)
    GTEST_SKIP() << "this kernel confines no processes";
  const test::TemporaryFolder folder;
  for (const char* name : {"given", "other"}) test::spit(folder / name, {'x'});
  const auto reached = [&]() -> Bytes {
    return {canRead(folder / "given"), canRead(folder / "other"), canRead("/etc/passwd"), canConnect()};
  };
  const auto inside = inConfinedChild({{folder / "given"}, {}}, kMost, reached);
  ASSERT_TRUE(inside.ok()) << inside.error().message;
  EXPECT_EQ(*inside, (Bytes{1, 0, 0, 0}));
  EXPECT_EQ(reached(), (Bytes{1, 1, 1, 1})) << "the parent is as free as before";
}

TEST(ConfinedChild, ThatFailsIsAnError) {
  const auto killed = inConfinedChild({}, kMost, []() -> Bytes {
    raise(SIGKILL);
    return {};
  });
  ASSERT_FALSE(killed.ok());
  EXPECT_NE(killed.error().message.find("signal 9"), std::string::npos) << killed.error().message;
  const auto failed = inConfinedChild({}, kMost, []() -> Bytes { _exit(3); });
  ASSERT_FALSE(failed.ok());
  const auto endless = inConfinedChild({}, 100, [] { return Bytes(kMost); });
  ASSERT_FALSE(endless.ok());
  EXPECT_EQ(endless.error().code, ErrorCode::kLimit);
}

}  // namespace
}  // namespace foreland::terrain
