// What may be read beside an input, through links and by any path. Names as models have them: neighbours_test.cpp.
#include "terrain/fence/file_fence.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>

#include "tests/support/files.h"

namespace foreland::terrain {
namespace {

namespace fs = std::filesystem;

class Folders : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"in", "in/below", "in2", "out"}) fs::create_directories(root_ / name);
    for (const char* name : {"in/a.obj", "in/a.mtl", "in/below/b.png", "in2/c.mtl", "out/secret"})
      test::spit(root_ / name, {'x'});
    fs::create_symlink(root_ / "out/secret", root_ / "in/link");
    fs::create_symlink(root_ / "in/a.mtl", root_ / "in/inner_link");
    fs::create_directory_symlink(root_ / "out", root_ / "in/folder_link");
  }
  bool mayName(const FileFence& fence, const std::string& named) const { return fence.mayRead(root_ / "in" / named); }
  test::TemporaryFolder root_;
};

TEST_F(Folders, HoldWhatLiesInThemOrBelow) {
  const FileFence fence(std::array{root_ / "in/a.obj"});
  for (const char* own : {"a.mtl", "./a.mtl", "below/b.png", "below/../a.mtl", "inner_link", "is_not_there.mtl"})
    EXPECT_TRUE(mayName(fence, own)) << own;
  for (const char* other :
       {"../out/secret", "link", "folder_link/secret", "../in2/c.mtl", "/etc/passwd", "below/../../out/secret"})
    EXPECT_FALSE(mayName(fence, other)) << other;
  EXPECT_TRUE(mayName(fence, root_ / "in/a.mtl"));
}

TEST_F(Folders, AreMoreIfTheUserAllowsThem) {
  const FileFence fence(std::array{root_ / "in/a.obj"}, std::array{root_ / "out"});
  EXPECT_TRUE(mayName(fence, "../out/secret"));
  EXPECT_TRUE(mayName(fence, "link"));
  EXPECT_FALSE(mayName(fence, "../in2/c.mtl"));
}

// Where a path leads that cannot be followed is not known, so it is not within. fuzz_mtls found that its folder was
// listed.
TEST_F(Folders, DoNotHoldWhatCannotBeResolved) {
  const FileFence fence(std::array{root_ / "in/a.obj"});
  const std::string far(5000, 'x');
  fs::create_symlink(root_ / "in/round", root_ / "in/round");
  for (const std::string& name : {far, "folder_link/" + far, far + "/../a.mtl", std::string("round/a.mtl")})
    EXPECT_FALSE(mayName(fence, name)) << name.substr(0, 20);
  EXPECT_NE(FileFence::refusal("a.obj", root_ / far).message.find("xxxx"), std::string::npos);
  const FileFence of_nothing(std::array{fs::path(far), fs::path()}, std::array{fs::path(far)});
  EXPECT_FALSE(of_nothing.mayRead(root_ / "in/a.mtl"));
  EXPECT_FALSE(of_nothing.mayRead(far));
}

// A link that the user names leads to a file whose neighbours are meant, too.
TEST_F(Folders, AreThoseThatALinkLeadsTo) {
  fs::create_symlink(root_ / "in/a.obj", root_ / "in2/model.obj");
  const FileFence fence(std::array{root_ / "in2/model.obj"});
  EXPECT_TRUE(fence.mayRead(root_ / "in/a.mtl"));
  EXPECT_TRUE(fence.mayRead(root_ / "in2/c.mtl"));
  EXPECT_FALSE(fence.mayRead(root_ / "out/secret"));
}

// An input at the top does not open all files there are.
TEST(FenceAtTheTop, HoldsTheFileAlone) {
  const FileFence fence(std::array{fs::path("/vmlinuz.tif")});
  EXPECT_TRUE(fence.mayRead("/vmlinuz.tif"));
  EXPECT_FALSE(fence.mayRead("/etc/passwd"));
}

TEST(FenceRefusal, SaysWhatWouldBeReadAndHowToAllowIt) {
  const std::string said = FileFence::refusal("a.vrt", "/etc/passwd").message;
  EXPECT_EQ(
      said,
      "a.vrt: would read /etc/passwd, which is outside of its folder; if you trust it, say --allow-files-from /etc");
}

}  // namespace
}  // namespace foreland::terrain
