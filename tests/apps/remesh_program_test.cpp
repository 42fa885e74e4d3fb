// `foreland remesh` as people run it: a model becomes a file that info and verify know; bad models are refused by name.
#include <gtest/gtest.h>
#include <png.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <ranges>

#include "terrain/model/png.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/files.h"
#include "tests/support/gltf.h"
#include "tests/support/images.h"
#include "tests/support/models.h"

namespace foreland::test {
namespace {

class RemeshProgram : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string output() const { return folder_ / "out.fls"; }

  TemporaryFolder folder_;
};

TEST_F(RemeshProgram, AModelBecomesAFileThatInfoAndVerifyKnow) {
  const std::string model = write("torus.obj", toObj(makeTorus(40, 20)));
  const ProgramResult made = runProgram(
      "remesh", {model, "-o", output(), "--levels", "3", "--base-triangles", "80", "--attempts", "3", "--json"},
      {.streams = Streams::kOutputOnly});
  ASSERT_EQ(made.exit_code, 0);
  const auto report = nlohmann::json::parse(made.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << made.output;
  EXPECT_EQ(report["base"]["triangles"], 80);
  EXPECT_EQ(report["full_triangles"], 80 * 64);
  EXPECT_EQ(report["flipped"], 0);
  EXPECT_LT(report["hausdorff"]["share_of_diagonal"], 0.01);

  const ProgramResult info = runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly});
  const auto about = nlohmann::json::parse(info.output, nullptr, false);
  ASSERT_FALSE(about.is_discarded()) << info.output;
  EXPECT_EQ(about["kind"], "surface");
  EXPECT_EQ(about["id"], report["id"]);
  EXPECT_EQ(about["base"]["border_edges"], 0);
  EXPECT_EQ(about["full_triangles"], report["full_triangles"]);
  EXPECT_NE(runProgram("info", {output()}).output.find("closed"), std::string::npos);
  const ProgramResult verified = runProgram("verify", {output()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
  EXPECT_NE(verified.output.find(output() + ": sound"), std::string::npos) << verified.output;
}

// A house in the coordinates of a map gets an origin of its own, which its file keeps.
TEST_F(RemeshProgram, AModelOnAMapIsMovedAndSaysSo) {
  terrain::Model cube = makeCube(2);
  for (glm::dvec3& p : cube.positions) p += glm::dvec3(562010.25, 5116006.75, 1204);
  const std::string model = write("house.obj", toObj(cube));
  const std::vector<std::string> few{"--levels", "1", "--base-triangles", "12", "--attempts", "1"};
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{model, "-o", output()};
    arguments.insert(arguments.end(), few.begin(), few.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram("remesh", arguments);
  };
  const auto about = [&] {
    return nlohmann::json::parse(runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly}).output,
                                 nullptr, false);
  };
  const ProgramResult made = run({});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_NE(made.output.find("its origin is (562011, 5116007, 1204)"), std::string::npos) << made.output;
  EXPECT_NE(made.output.find("--object out.fls@here"), std::string::npos) << made.output;
  EXPECT_NE(made.output.find("--origin file"), std::string::npos) << made.output;
  const auto moved = about();
  EXPECT_EQ(moved["origin"][0], 562011);
  EXPECT_EQ(moved["origin"][1], 5116007);
  EXPECT_LT(moved["high"][0].get<double>(), 10);
  EXPECT_NE(runProgram("info", {output()}).output.find("origin     (562011, 5116007, 1204)"), std::string::npos);
  EXPECT_EQ(runProgram("verify", {output()}).exit_code, 0);

  const ProgramResult chosen = run({"--origin", "562000,5116000,0"});
  EXPECT_EQ(chosen.exit_code, 0) << chosen.output;
  EXPECT_EQ(about()["origin"], nlohmann::json({562000.0, 5116000.0, 0.0}));
  EXPECT_NEAR(about()["high"][2].get<double>(), 1205, 2);
  const ProgramResult kept = run({"--origin", "file"});
  EXPECT_EQ(kept.exit_code, 0) << kept.output;
  EXPECT_EQ(kept.output.find("its origin"), std::string::npos) << kept.output;
  EXPECT_GT(about()["low"][1].get<double>(), 5.1e6);
  expectRefusal("remesh", {model, "-o", output(), "--origin", "file", "--step", "1e-6"},
                {"house.obj", "--origin", "--step"});
  for (const char* wrong : {"1,2", "1,2,3,4", "here", "1,2,nan"})
    expectRefusal("remesh", {model, "-o", output(), "--origin", wrong}, {"--origin", "X,Y,Z"});
}

TEST_F(RemeshProgram, ReadsFilesOfOtherFoldersOnlyIfAllowed) {
  write("library/red.mtl", "newmtl red\nKd 1 0 0\n");
  const std::string model = write("model/m.obj", "mtllib ../library/red.mtl\nusemtl red\n" + toObj(makeSphere(1)));
  const std::vector<std::string> arguments{model, "-o",         output(), "--levels", "1", "--base-triangles",
                                           "8",   "--attempts", "1"};
  const ProgramResult fenced = runProgram("remesh", arguments);
  EXPECT_EQ(fenced.exit_code, 0) << fenced.output;
  EXPECT_NE(fenced.output.find("image 0 x 0"), std::string::npos) << fenced.output;
  EXPECT_NE(fenced.output.find("--allow-files-from "), std::string::npos) << fenced.output;
  auto allowing = arguments;
  allowing.insert(allowing.end(), {"--allow-files-from", folder_ / "library"});
  const ProgramResult allowed = runProgram("remesh", allowing);
  EXPECT_EQ(allowed.exit_code, 0) << allowed.output;
  EXPECT_EQ(allowed.output.find("image 0 x 0"), std::string::npos) << allowed.output;
}

// A torus that grows and leans over.
terrain::Model leaning(double by) {
  terrain::Model model = makeTorus(40, 20);
  for (glm::dvec3& p : model.positions) p = {p.x + by * p.z, p.y, p.z * (1 + by)};
  return model;
}

TEST_F(RemeshProgram, PosesBecomeOneSurface) {
  std::vector<std::string> arguments{write("torus.obj", toObj(leaning(0.1))),
                                     "-o",
                                     output(),
                                     "--levels",
                                     "3",
                                     "--base-triangles",
                                     "80",
                                     "--attempts",
                                     "3",
                                     "--json"};
  for (const auto& [date, by] : {std::pair("2001-01-01", 0.0), {"2001-02-01", 0.4}, {"2002-02-01", 0.5}}) {
    arguments.emplace_back("--pose");
    arguments.push_back(std::string(date) + "=" + write(std::string(date) + ".obj", toObj(leaning(by))));
  }
  const ProgramResult made = runProgram("remesh", arguments, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(made.exit_code, 0);
  const auto report = nlohmann::json::parse(made.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << made.output;
  ASSERT_EQ(report["poses"].size(), 3u);
  EXPECT_EQ(report["poses"][1]["date"], "2001-02-01");
  for (const auto& pose : report["poses"]) EXPECT_LT(pose["share_of_diagonal"], 0.01);
  const ProgramResult info = runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly});
  const auto about = nlohmann::json::parse(info.output, nullptr, false);
  ASSERT_FALSE(about.is_discarded()) << info.output;
  EXPECT_EQ(about["poses"], (std::vector<std::string>{"2001-01-01", "2001-02-01", "2002-02-01"}));
  const ProgramResult verified = runProgram("verify", {output()});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
}

TEST_F(RemeshProgram, RefusesWhatAreNoPoses) {
  const std::string model = write("torus.obj", toObj(makeTorus(40, 20)));
  const std::string other = write("other.obj", toObj(makeTorus(20, 40))),
                    fewer = write("fewer.obj", toObj(makeTorus(39, 20)));
  const auto refuses = [&](const std::vector<std::string>& poses, const std::vector<std::string>& named) {
    std::vector<std::string> arguments{model, "-o", output(), "--attempts", "1"};
    for (const std::string& pose : poses) arguments.insert(arguments.end(), {"--pose", pose});
    expectRefusal("remesh", arguments, named);
  };
  const std::string first = "2001-01-01=" + model;
  refuses({first}, {"1 times"});
  refuses({first, "2001-01-01=" + model}, {"must ascend"});
  refuses({first, "2000-12-31=" + model}, {"must ascend"});
  refuses({first, "2001-13-01=" + model}, {"2001-13-01", "YYYY-MM-DD=FILE"});
  refuses({first, "2001-02-01=" + other}, {"other.obj"});
  refuses({first, "2001-02-01=" + fewer}, {"fewer.obj", "vertices"});
  refuses({first, "2001-02-01=missing.obj"}, {"missing.obj"});
}

TEST_F(RemeshProgram, VerifyFindsAFlippedByteAnywhere) {
  ASSERT_EQ(runProgram("remesh", {write("a.obj", toObj(makeSphere(3))), "-o", output(), "--levels", "3",
                                  "--base-triangles", "20", "--attempts", "1"})
                .exit_code,
            0);
  const auto bytes = slurp(output());
  for (const double share : {0.0, 0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999}) {
    auto damaged = bytes;
    damaged[static_cast<size_t>(share * static_cast<double>(bytes.size()))] ^= 0x10;
    spit(output(), damaged);
    expectRefusal("verify", {output()}, {output()});
  }
}

TEST_F(RemeshProgram, TheSameModelGivesTheSameBytesForAnyNumberOfThreads) {
  const std::string model = write("patch.obj", toObj(makePatch(16)));
  for (const char* threads : {"1", "3"})
    ASSERT_EQ(runProgram("remesh", {model, "-o", folder_ / threads, "--levels", "3", "--base-triangles", "30",
                                    "--attempts", "2", "--threads", threads})
                  .exit_code,
              0);
  EXPECT_EQ(slurp(folder_ / "1"), slurp(folder_ / "3"));
}

TEST_F(RemeshProgram, TexturesComeAlongAndThoseThatAreMissingAreNoted) {
  terrain::Model model = makePatch(8);
  for (size_t c = 0; c < model.corners.size(); ++c) {
    const glm::dvec3& p = model.positions[model.corners[c].vertex];
    model.corners[c].texture = static_cast<uint32_t>(c);
    model.texture_coordinates.emplace_back(p.x, p.y);
  }
  write("skin.mtl", "newmtl skin\nKd 0 1 0\nmap_Kd skin.png\n");
  const std::string path = write("patch.obj", "mtllib skin.mtl\nusemtl skin\n" + toObj(model));
  const std::vector<std::string> arguments{path, "-o",         output(), "--levels", "3", "--base-triangles",
                                           "16", "--attempts", "1"};
  const ProgramResult without = runProgram("remesh", arguments);
  EXPECT_EQ(without.exit_code, 0) << without.output;
  EXPECT_NE(without.output.find("without the texture of material 'skin'"), std::string::npos) << without.output;
  EXPECT_NE(without.output.find("skin.png"), std::string::npos) << without.output;

  std::vector<uint32_t> pixels(64 * 64, 0xff0000ff);
  png_image png{};
  png.version = PNG_IMAGE_VERSION, png.width = png.height = 64, png.format = PNG_FORMAT_RGBA;
  ASSERT_TRUE(png_image_write_to_file(&png, std::string(folder_ / "skin.png").c_str(), 0, pixels.data(), 0, nullptr));
  const ProgramResult with = runProgram("remesh", arguments);
  EXPECT_EQ(with.exit_code, 0) << with.output;
  EXPECT_EQ(with.output.find("without"), std::string::npos) << with.output;
  const auto about = nlohmann::json::parse(
      runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly}).output, nullptr, false);
  // 64 x 64 texels over 16 half-squares: 22 or 23 along an edge, rounded up to a multiple of four.
  EXPECT_EQ(about["image"]["texels_per_base_edge"], 24);
  EXPECT_EQ(about["base"]["border_edges"].get<int>() > 0, true);
}

// Two bodies that share a vertex, as a teapot's lid and its knob do, a face that is there twice, one that is a line and
// one that is turned over.
terrain::Model touchingBodies() {
  terrain::Model model = makeSphere(2);
  const auto count = static_cast<uint32_t>(model.positions.size());
  const auto add = [&](std::array<uint32_t, 3> face) {
    for (const uint32_t v : face) model.corners.push_back({v, terrain::kNoIndex});
    model.face_ends.push_back(model.corners.size());
    model.face_materials.push_back(terrain::kNoIndex);
  };
  for (const glm::dvec3& p : makeSphere(2).positions) model.positions.push_back(0.3 * p + glm::dvec3(0, 0, 1.3));
  for (const auto sphere = makeSphere(2); const size_t f : std::views::iota(size_t{0}, sphere.faceCount())) {
    std::array<uint32_t, 3> face{};
    for (size_t k = 0; k < 3; ++k) face[k] = sphere.corners[3 * f + k].vertex + count;
    for (uint32_t& v : face) v = v == count + 5 ? 4 : v;  // the lowest vertex is the other sphere's highest
    add(face);
  }
  add({model.corners[0].vertex, model.corners[1].vertex, model.corners[1].vertex});
  add({model.corners[0].vertex, model.corners[1].vertex, model.corners[2].vertex});
  std::swap(model.corners[30], model.corners[31]);
  return model;
}

TEST_F(RemeshProgram, WhatIsNoSurfaceIsRepairedWithNotesOrRefusedIfAsked) {
  const std::string model = write("touching.obj", toObj(touchingBodies()));
  std::vector<std::string> arguments{model, "-o",         output(), "--levels", "3", "--base-triangles",
                                     "60",  "--attempts", "2",      "--json"};
  const ProgramResult made = runProgram("remesh", arguments, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(made.exit_code, 0);
  const auto report = nlohmann::json::parse(made.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << made.output;
  EXPECT_EQ(report["repairs"],
            nlohmann::json::parse(R"({"welded_vertices": 0, "repeated_corners": 0, "degenerate_faces": 1,
            "duplicate_faces": 1, "cut_edges": 0, "split_vertices": 1, "turned_faces": 1})"));
  EXPECT_EQ(report["flipped"], 0);
  EXPECT_GT(report["flipped_as_given"], 0);
  EXPECT_LT(report["hausdorff"]["share_of_diagonal"], 0.03);
  EXPECT_EQ(report["notes"].size(), 5u);
  const std::string info = runProgram("info", {output()}).output;
  for (const char* note : {"1 face without area dropped", "1 face dropped that repeats another",
                           "1 vertex split at which parts touch", "1 face turned over"})
    EXPECT_NE(info.find(note), std::string::npos) << info;
  std::filesystem::remove(output());
  arguments.push_back("--strict");
  expectRefusal("remesh", arguments, {model, "two corners at the position of vertex 1"});
  EXPECT_FALSE(std::filesystem::exists(output()));
}

TEST_F(RemeshProgram, AnStlCubeIsTheSameInBothForms) {
  const terrain::Model cube = inTriangles(makeCube(2));
  const std::string files[] = {write("binary/cube.stl", toBinaryStl(cube)), write("text/cube.stl", toTextStl(cube))};
  std::vector<char> first;
  for (const std::string& file : files) {
    ASSERT_EQ(runProgram("remesh", {file, "-o", output(), "--levels", "2", "--base-triangles", "12", "--attempts", "1"})
                  .exit_code,
              0);
    const auto about = nlohmann::json::parse(
        runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly}).output, nullptr, false);
    EXPECT_EQ(about["base"]["border_edges"], 0);
    if (first.empty()) first = slurp(output());
    EXPECT_EQ(slurp(output()), first);
  }
}

// A bumpy square in the picture's colours; `image` is the file of the picture.
std::string texturedGlb(const Bytes& image) {
  const terrain::Model patch = inTriangles(makePatch(8));
  GltfFile file = toGltf(patch);
  std::vector<float> coordinates;
  for (const glm::dvec3& p : patch.positions)
    coordinates.insert(coordinates.end(), {static_cast<float>(p.x), static_cast<float>(p.y)});
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] =
      file.addAccessor(file.addView(bytesOf(coordinates)), 5126, "VEC2", patch.positions.size());
  primitive["material"] = 0;
  file.append("images", {{"bufferView", file.addView(image)}});
  file.append("textures", {{"source", 0}});
  file.append("materials", {{"name", "skin"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  return file.toGlb();
}

TEST_F(RemeshProgram, TexturesOfAGlbReachTheSurfaceFromEachFormat) {
  const terrain::Image picture{64, 64, std::vector<terrain::Colour>(64 * 64, {255, 128, 0, 255})};
  const Bytes broken{1, 2, 3};
  for (const Bytes& image : {terrain::encodePng(picture).value(), toJpeg(picture), toWebp(picture), broken}) {
    const std::string model = write("patch.glb", texturedGlb(image));
    const ProgramResult made =
        runProgram("remesh", {model, "-o", output(), "--levels", "3", "--base-triangles", "16", "--attempts", "1"});
    EXPECT_EQ(made.exit_code, 0) << made.output;
    const auto about = nlohmann::json::parse(
        runProgram("info", {output(), "--json"}, {.streams = Streams::kOutputOnly}).output, nullptr, false);
    EXPECT_EQ(about["image"]["texels_per_base_edge"], image == broken ? 4 : 24);
    EXPECT_EQ(made.output.find("without the texture of material 'skin'") != std::string::npos, image == broken)
        << made.output;
  }
}

TEST_F(RemeshProgram, TheSameMeshIsTheSameSurfaceFromAnyFormat) {
  terrain::Model torus = inTriangles(makeTorus(20, 10));
  for (glm::dvec3& p : torus.positions) p = glm::dvec3(glm::vec3(p));
  const std::string files[] = {write("torus.obj", toObj(torus)), write("torus.glb", toGltf(torus).toGlb()),
                               write("torus.gltf", toGltf(torus).toText())};
  std::vector<double> distances;
  for (const std::string& file : files) {
    const ProgramResult made = runProgram(
        "remesh",
        {file, "-o", output(), "--levels", "2", "--base-triangles", "40", "--attempts", "1", "--up", "y", "--json"},
        {.streams = Streams::kOutputOnly});
    ASSERT_EQ(made.exit_code, 0) << file;
    const auto report = nlohmann::json::parse(made.output, nullptr, false);
    distances.push_back(report["hausdorff"]["surface_to_original"]);
    EXPECT_EQ(report["original"]["triangles"], 400);
  }
  EXPECT_EQ(distances, std::vector(3, distances[0]));
}

TEST_F(RemeshProgram, BadModelsAndOptionsAreRefusedByName) {
  const std::string crowded =
      write("crowded.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  const std::string empty = write("empty.obj", "");
  const std::string huge = write("huge.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string good = write("good.obj", toObj(makeSphere(2)));
  expectRefusal("remesh", {crowded, "-o", output(), "--strict"}, {crowded, "face 3", "vertex 1", "vertex 2"});
  expectRefusal("remesh", {empty, "-o", output()}, {empty, "no face"});
  expectRefusal("remesh", {huge, "-o", output()}, {huge, "vertex 2", "1e9"});
  expectRefusal("remesh", {write("broken.glb", "glTF"), "-o", output()}, {"broken.glb", "cut short"});
  expectRefusal("remesh", {folder_ / "missing.obj", "-o", output()}, {"missing.obj"});
  expectRefusal("remesh", {good, "-o", folder_ / "nowhere" / "out.fls"}, {"nowhere"});
  expectRefusal("remesh", {good, "-o", good}, {"is the model"});
  expectRefusal("remesh", {good, "-o", folder_.path()}, {"directory"});
  expectRefusal("remesh", {good, "-o", output(), "--levels", "0"}, {"--levels", "--help"});
  expectRefusal("remesh", {good, "-o", output(), "--step", "nan"}, {"nan"});
  expectRefusal("remesh", {good, "-o", output(), "--step", "1e-15"}, {"coarser"});
  expectRefusal("remesh", {good, "-o", output(), "--levels", "2", "--attempts", "1"}, {"cannot reserve"},
                {.largest_file_bytes = 1000});
  EXPECT_EQ(filesIn(folder_.path()), 5u);
}

}  // namespace
}  // namespace foreland::test
