#include "terrain/model/neighbours.h"

#include <gtest/gtest.h>

#include <fstream>

#include "terrain/model/read_model.h"
#include "tests/support/files.h"
#include "tests/support/gltf.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

namespace fs = std::filesystem;

class NeighboursTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"model/m.obj", "model/a b.png", "model/Skin.PNG", "model/sub/s.mtl", "model/sub/t.png",
                             "other/t.png", "other/secret.png"})
      write(name, "x");
  }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  // Relative to the temporary folder, or the error's words.
  std::string find(const std::string& name, const std::string& namer = "model/m.obj",
                   const std::vector<fs::path>& allowed = {}) const {
    const auto found = Neighbours(folder_ / "model/m.obj", allowed).find(name, folder_ / namer);
    return found.ok() ? fs::weakly_canonical(*found).lexically_relative(fs::canonical(folder_.path())).string()
                      : found.error().message;
  }

  test::TemporaryFolder folder_;
};

TEST_F(NeighboursTest, AreFoundAsProgramsNameThem) {
  EXPECT_EQ(find("a b.png"), "model/a b.png");
  EXPECT_EQ(find("\"a b.png\""), "model/a b.png");
  EXPECT_EQ(find("skin.png"), "model/Skin.PNG");
  EXPECT_EQ(find("sub/t.png"), "model/sub/t.png");
  EXPECT_EQ(find("sub\\t.png"), "model/sub/t.png");
  EXPECT_EQ(find("./sub/../sub/t.png"), "model/sub/t.png");
  EXPECT_EQ(find("t.png", "model/sub/s.mtl"), "model/sub/t.png") << "beside the library that names it";
  EXPECT_EQ(find("Skin.PNG", "model/sub/s.mtl"), "model/Skin.PNG") << "beside the model";
}

TEST_F(NeighboursTest, PathsOfOtherMachinesMeanTheFileBesideTheModel) {
  for (const char* name :
       {"C:\\work\\t.png", "C:/work/t.png", "/home/me/t.png", "../other/t.png", "file:///home/me/t.png"})
    EXPECT_EQ(find(name, "model/sub/s.mtl"), "model/sub/t.png") << name;
}

// The file system refuses them by an exception, unless it is asked not to.
TEST_F(NeighboursTest, NamesThatAreTooLongAreNamed) {
  const std::string far(5000, 'x');
  for (const std::string& name : {far, "/" + far, "../" + far, far + "/a", "C:\\" + far})
    EXPECT_NE(find(name).find("xxx"), std::string::npos) << name.substr(0, 9);
}

TEST_F(NeighboursTest, LieInTheModelsFolderUnlessAllowed) {
  const std::string outside = (folder_ / "other/secret.png").string();
  fs::create_symlink(folder_ / "other/secret.png", folder_ / "model/link.png");
  fs::create_directory_symlink(folder_ / "other", folder_ / "model/linked");
  for (const std::string& name : {std::string("../other/secret.png"), outside, std::string("link.png"),
                                  std::string("linked/secret.png"), std::string("..\\other\\secret.png"),
                                  std::string("sub/../../other/secret.png"), std::string("../other/none.png")}) {
    const std::string words = find(name);
    EXPECT_NE(words.find("outside of its folder"), std::string::npos) << name << ": " << words;
    EXPECT_NE(words.find("--allow-files-from " + fs::canonical(folder_ / "other").string()), std::string::npos)
        << words;
  }
  for (const char* name : {"http://host/secret.png", "file:///etc/passwd", "D:secret.png"})
    EXPECT_NE(find(name).find("no file of its folder; put the file beside the model"), std::string::npos) << find(name);
  for (const std::string& name : {std::string("../other/secret.png"), outside, std::string("link.png"),
                                  std::string("linked/secret.png"), std::string("..\\other\\secret.png")})
    EXPECT_EQ(find(name, "model/m.obj", {folder_ / "other"}), "other/secret.png") << name;
  EXPECT_EQ(find("../other/secret.png", "model/m.obj", {(folder_ / "other").string() + "/"}), "other/secret.png");
  EXPECT_NE(find("../other/secret.png", "model/m.obj", {folder_ / "othe"}).find("outside"), std::string::npos);
}

TEST_F(NeighboursTest, AreNamedIfThereAreNone) {
  EXPECT_NE(find("gone.png").find("gone.png: there is no such file; put it beside the model"), std::string::npos);
  EXPECT_NE(find("sub").find("no such file"), std::string::npos) << "a folder is no file";
  for (const std::string& name : {std::string(), std::string("."), std::string(".."), std::string("a\0b", 3)})
    EXPECT_FALSE(Neighbours(folder_ / "model/m.obj").find(name).ok());
}

TEST_F(NeighboursTest, ModelsReadNoOtherFile) {
  write("other/m.mtl", "newmtl red\nKd 1 0 0\nmap_Kd ../other/t.png\n");
  write("model/m.obj", "mtllib ../other/m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto fenced = readModel(folder_ / "model/m.obj");
  ASSERT_TRUE(fenced.ok()) << fenced.error().message;
  EXPECT_TRUE(fenced->materials.empty());
  ASSERT_EQ(fenced->notes.size(), 1u);
  EXPECT_NE(fenced->notes[0].find("outside of its folder"), std::string::npos) << fenced->notes[0];
  const auto allowed = readModel(folder_ / "model/m.obj", {folder_ / "other"});
  ASSERT_TRUE(allowed.ok()) << allowed.error().message;
  ASSERT_EQ(allowed->materials.size(), 1u);
  EXPECT_TRUE(fs::equivalent(allowed->materials[0].texture, folder_ / "other/t.png"));

  const test::GltfFile file = test::toGltf(test::makeSphere(0));
  write("other/mesh.bin", std::string(file.buffer.begin(), file.buffer.end()));
  for (const char* uri : {"../other/mesh.bin", "%2e%2e/other/mesh.bin", "..\\other\\mesh.bin"}) {
    write("model/m.gltf", file.toText(uri));
    const auto refused = readModel(folder_ / "model/m.gltf");
    ASSERT_FALSE(refused.ok()) << uri;
    EXPECT_NE(refused.error().message.find("outside of its folder"), std::string::npos) << refused.error().message;
    EXPECT_TRUE(readModel(folder_ / "model/m.gltf", {folder_ / "other"}).ok()) << uri;
  }
}

TEST_F(NeighboursTest, ATextureIsBesideTheLibraryThatNamesIt) {
  write("model/sub/s.mtl", "newmtl red\nmap_Kd t.png\n");
  for (const char* library : {"sub/s.mtl", "sub\\s.mtl"}) {
    write("model/m.obj", std::string("mtllib ") + library + "\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto model = readModel(folder_ / "model/m.obj");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->notes, std::vector<std::string>());
    EXPECT_TRUE(fs::equivalent(model->materials.at(0).texture, folder_ / "model/sub/t.png"));
  }
}

}  // namespace
}  // namespace foreland::terrain
