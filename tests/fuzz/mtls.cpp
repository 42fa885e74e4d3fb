// An OBJ model with a material library of a stranger, read from a folder with all that they name: libraries, textures,
// in whatever writing. Whatever they say, nothing outside of the folder is opened or listed (the kernel tells), and
// textures that are found lie in it; or the message names the model. The input: the model's text, after the first
// zero the library's; bytes from 128 on stand for words (kWords).
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "base/check.h"
#include "terrain/model/read_model.h"
#include "tests/support/files.h"
#include "tests/support/watched_folder.h"

namespace {

using namespace foreland;

constexpr std::string_view kWords[] = {
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n",
    "mtllib ",
    "usemtl ",
    "newmtl ",
    "map_Kd ",
    "map_Ka ",
    "Kd 1 0 0\n",
    "d 0.5\n",
    "-s 1 1 1 ",
    "-blendu on ",
    "m.mtl",
    "m.obj",
    "own.png",
    "Own.PNG",
    "below/own.png",
    "below\\own.png",
    "link.png",
    "folder/secret.png",
    "OUTSIDE/secret.png",
    "OUTSIDE/secret.mtl",
    "OUTSIDE",
    "../",
    "..\\",
    "./",
    "C:\\",
    "C:/",
    "\\\\server\\share\\",
    "file://",
    "http://127.0.0.1:9/",
    "/etc/passwd",
    "/proc/self/",
    "/vsizip/",
    "%2e%2e/",
    "~/",
    "$HOME/",
    "\"",
    " #",
    "#MRGB ffff0000",
    "\\\n",
    "\r",
    "\xef\xbb\xbf",
    "\xff\xfe",
};

struct Place {
  test::WatchedFolder outside;
  test::TemporaryFolder folder;

  Place() {
    for (const char* name : {"secret.png", "secret.mtl"}) std::ofstream(outside.path() / name) << "newmtl a\n";
    std::filesystem::create_directory(folder / "below");
    for (const char* name : {"own.png", "below/own.png"}) std::ofstream(folder / name) << "an image";
    std::filesystem::create_symlink(outside.path() / "secret.png", folder / "link.png");
    std::filesystem::create_directory_symlink(outside.path(), folder / "folder");
    (void)outside.events();
  }
  void write(const char* name, std::span<const uint8_t> input) const {
    std::filesystem::remove(folder / name);
    std::ofstream out(folder / name, std::ios::binary);
    for (const uint8_t byte : input) {
      const std::string_view word = byte < 128 ? std::string_view() : kWords[(byte - 128) % std::size(kWords)];
      if (byte < 128)
        out << static_cast<char>(byte);
      else if (word.starts_with("OUTSIDE"))
        out << outside.path().string() << word.substr(7);
      else
        out << word;
    }
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Place place;
  const std::span<const uint8_t> input(data, size);
  const auto cut = static_cast<size_t>(std::find(input.begin(), input.end(), 0) - input.begin());
  place.write("m.obj", input.first(cut));
  place.write("m.mtl", input.subspan(std::min(cut + 1, size)));
  const auto model = terrain::readModel(place.folder / "m.obj");
  if (!model.ok()) CHECK_TRUE(model.error().message.find("m.obj") != std::string::npos);
  if (model.ok())
    for (const terrain::Material& material : model->materials)
      if (!material.texture.empty()) {
        const std::string found = std::filesystem::canonical(material.texture).string();
        CHECK_TRUE(found.starts_with(std::filesystem::canonical(place.folder.path()).string() + "/"));
      }
  CHECK_EQ(place.outside.events(), "");
  return 0;
}
