// Readers of model files: what they read, and what they refuse and name.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>

#include "base/rng.h"
#include "terrain/model/read_model.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

Result<Model> obj(std::string_view text, std::string_view library = {}) {
  return parseObj(text, "m.obj", [&](const std::string&) -> Result<Bytes> {
    if (library.empty()) return Error{ErrorCode::kNotFound, "no library"};
    return Bytes(library.begin(), library.end());
  });
}
Result<Model> ply(const std::string& text) {
  return parsePly({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, "m.ply");
}
void expectRefusal(const Result<Model>& model, const std::string& words) {
  ASSERT_FALSE(model.ok()) << words;
  EXPECT_NE(model.error().message.find(words), std::string::npos) << model.error().message;
}

TEST(Obj, GivesBackAWrittenModel) {
  Model torus = test::makeTorus(7, 5);
  for (size_t c = 0; c < torus.corners.size(); ++c) {
    torus.texture_coordinates.emplace_back(double(c) / 3, 1 - double(c) / 7);
    torus.corners[c].texture = static_cast<uint32_t>(c);
  }
  const auto read = obj(test::toObj(torus));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->positions, torus.positions);
  EXPECT_EQ(read->texture_coordinates, torus.texture_coordinates);
  EXPECT_EQ(read->face_ends, torus.face_ends);
  for (size_t c = 0; c < torus.corners.size(); ++c) {
    EXPECT_EQ(read->corners[c].vertex, torus.corners[c].vertex);
    EXPECT_EQ(read->corners[c].texture, torus.corners[c].texture);
  }
}

TEST(Obj, ReadsWhatExportersWrite) {
  const auto read =
      obj("# comment\r\nmtllib a b.mtl\no thing\nv 0 0 0 1 0 0\nv +1 0 0 0 1 0\nv 1 1e0 0 # here\nv 0 1 0\n"
          "vt .5 .25\nvn 0 0 1\ns off\nusemtl red paint\nf 1/1/1 2//1 3 -1\nusemtl plain\nf 1 2 \\\n 3\n",
          "newmtl red paint\nKd 1 0.5 0\nmap_Kd -s 1 1 1 -blendu on wood grain.png\nnewmtl plain\nKd 0 0 2\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->face_ends, (std::vector<uint64_t>{4, 7}));
  EXPECT_EQ(read->corners[0].texture, 0u);
  EXPECT_EQ(read->corners[1].texture, kNoIndex);
  EXPECT_EQ(read->corners[3].vertex, 3u);
  EXPECT_EQ(read->face_materials, (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(read->materials[0].texture, "wood grain.png");
  EXPECT_EQ(read->materials[0].colour, (Colour{255, 128, 0, 255}));
  EXPECT_EQ(read->materials[1].colour, (Colour{0, 0, 255, 255}));
  EXPECT_EQ(read->colours,
            (std::vector<Colour>{{255, 0, 0, 255}, {0, 255, 0, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}}));
}

// The four corners of a square, of which the first line is easily lost.
const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\nf 1 3 4\n";

std::string wide(const std::string& text, bool is_big) {
  std::string out = is_big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) {
    if (is_big) out += '\0';
    out += c;
    if (!is_big) out += '\0';
  }
  return out;
}

TEST(Obj, ReadsAnyEncodingAndLineEnds) {
  std::string dos = kSquare, mac = kSquare;
  for (size_t at = 0; (at = dos.find('\n', at)) != std::string::npos; at += 2) dos.replace(at, 1, "\r\n");
  for (char& c : mac) c = c == '\n' ? '\r' : c;
  for (const std::string& text :
       {kSquare, "\xef\xbb\xbf" + kSquare, wide(kSquare, false), wide(kSquare, true), wide(kSquare, false).substr(2),
        wide(kSquare, true).substr(2), dos, mac, wide(mac, true)}) {
    const auto read = obj(text);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->positions.size(), 5u);
    EXPECT_EQ(read->positions[0], glm::dvec3(0, 0, 0));
    EXPECT_EQ(read->positions[2], glm::dvec3(1, 1, 0));
    EXPECT_EQ(read->corners[2].vertex, 2u) << "the first line is not lost";
    EXPECT_EQ(read->notes, std::vector<std::string>());
  }
  expectRefusal(obj(std::string("\xff\xfe\0\0v\0\0\0", 8)), "m.obj: is text in UTF-32");
  const auto coloured = obj("mtllib m.mtl\nusemtl red\n" + kSquare, wide("newmtl red\rKd 1 0 0\r", true));
  ASSERT_TRUE(coloured.ok());
  EXPECT_EQ(coloured->materials.at(0).colour, (Colour{255, 0, 0, 255}));
}

TEST(Obj, AMissingLibraryIsANote) {
  const auto read = obj("mtllib nowhere.mtl\nmtllib nowhere.mtl\nusemtl red\n" + kSquare);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->notes, std::vector<std::string>{"without the colours of its material library: no library"});
  const auto unknown = obj("mtllib m.mtl\nusemtl blue\n" + kSquare, "newmtl red\n");
  ASSERT_TRUE(unknown.ok()) << unknown.error().message;
  EXPECT_EQ(unknown->notes, std::vector<std::string>{"materials of faces that are in no material library left out: 2"});
  EXPECT_EQ(unknown->face_materials[0], kNoIndex);
}

TEST(Obj, LooksForABoundedNumberOfLibraries) {
  std::string text, line = "mtllib";
  for (int i = 0; i < 300; ++i) text += "mtllib " + std::to_string(i) + ".mtl\n", line += " x" + std::to_string(i);
  size_t asked = 0;
  const auto read = parseObj(line + "\n" + text + kSquare, "m.obj", [&](const std::string& name) -> Result<Bytes> {
    ++asked;
    return Error{ErrorCode::kNotFound, name.substr(0, 9)};
  });
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(asked, 1u + 256 + 255);
  EXPECT_EQ(read->notes.size(), 257u);
  EXPECT_EQ(read->notes.back(), "material libraries after the 256th left out: 45");
}

TEST(Obj, ReadsSeveralLibrariesOfOneLine) {
  const auto read =
      parseObj("mtllib a.mtl b.mtl\nusemtl b\n" + kSquare, "m.obj", [](const std::string& name) -> Result<Bytes> {
        const std::string text = "newmtl " + name.substr(0, 1) + "\n";
        if (name.size() > 5) return Error{ErrorCode::kNotFound, name};
        return Bytes(text.begin(), text.end());
      });
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->notes, std::vector<std::string>());
  ASSERT_EQ(read->materials.size(), 2u);
  EXPECT_EQ(read->materials[1].library, "b.mtl");
  EXPECT_EQ(read->face_materials[0], 1u);
}

TEST(Obj, WhatIsNotTakenIsCounted) {
  const auto read = obj("mtllib m.mtl\nl 1 2\np 1\np 2\ncurv 0 1 1 2\nhello\nvn 0 0 1\ng a\n" + kSquare,
                        "newmtl a\nd 0.5\nTr 0.5\nmap_Bump b.png\nmap_Kd -s 2 2 2 c.png\nnewmtl b\nd 1\nTr 0\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->notes,
            (std::vector<std::string>{"lines and points left out: 3", "lines that are of no kind of OBJ left out: 1",
                                      "maps of materials (bump, gloss, opacity and their like) left out: 1",
                                      "opacities of materials (d, Tr) left out: 2",
                                      "options of textures (map_Kd -s, -o and their like) left out: 1",
                                      "parts of free-form curves and surfaces left out: 1"}));
}

// `#` begins a comment where no name may have it.
TEST(Obj, NamesMayHaveANumberSign) {
  const auto read = [](const std::string& text, const std::string& library) {
    return parseObj(text, "m.obj", [&](const std::string& name) -> Result<Bytes> {
      if (name != "part #2.mtl") return Error{ErrorCode::kNotFound, name};
      return Bytes(library.begin(), library.end());
    });
  };
  for (const char* comment : {"", " # written by hand", "\t#2"}) {
    const auto model =
        read(std::string("mtllib part #2.mtl") + comment + "\no a#1\ng b # c\nusemtl red#3" + comment + "\n" + kSquare,
             "newmtl red\nKd 0 0 1\nnewmtl red#3 # the third\nKd 1 0 0 # red\nmap_Kd wood#1.png\n");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->notes, std::vector<std::string>()) << comment;
    ASSERT_EQ(model->materials.size(), 2u);
    EXPECT_EQ(model->face_materials[0], 1u) << comment;
    EXPECT_EQ(model->materials[1].colour, (Colour{255, 0, 0, 255}));
    EXPECT_EQ(model->materials[1].texture, "wood#1.png");
  }
  const auto missing = read("mtllib other.mtl # gone\n" + kSquare, "");
  ASSERT_TRUE(missing.ok()) << missing.error().message;
  EXPECT_EQ(missing->notes, std::vector<std::string>{"without the colours of its material library: other.mtl"});
}

TEST(Obj, TexturesMayHaveANumberSign) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "wood #1.png") << "an image";
  for (const char* comment : {"", " # of oak", "\t# of oak"}) {
    std::ofstream(folder / "m.mtl") << "newmtl a\nmap_Kd wood #1.png" << comment << "\n";
    std::ofstream(folder / "m.obj") << "mtllib m.mtl\nusemtl a\n" << kSquare;
    const auto model = readModel(folder / "m.obj");
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->materials.at(0).texture.filename(), "wood #1.png") << comment;
  }
}

TEST(Obj, ReadsThePaintOfZBrush) {
  const auto painted = obj("#MRGB ffFF0000ff00ff00\n#MRGB ff0000Ff\n" + kSquare);
  ASSERT_TRUE(painted.ok()) << painted.error().message;
  const Colour white{255, 255, 255, 255};
  EXPECT_EQ(painted->colours,
            (std::vector<Colour>{{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, white, white}));
  EXPECT_EQ(painted->notes, std::vector<std::string>());
  const auto odd = obj("#MRGB ffff0000ff0\n#MRGB ffzz0000\n#MRGB " + std::string(48, '0') + "\n# MRGB\n" + kSquare);
  ASSERT_TRUE(odd.ok()) << odd.error().message;
  EXPECT_EQ(odd->colours.size(), 5u);
  EXPECT_EQ(odd->notes, (std::vector<std::string>{"colours of #MRGB behind the last vertex left out: 2",
                                                  "lines of #MRGB that are no colours left out: 2"}));
  const auto both = obj("#MRGB ff00ff00\nv 0 0 0 1 1 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  ASSERT_TRUE(both.ok()) << both.error().message;
  EXPECT_EQ(both->colours[0], (Colour{255, 0, 0, 255}));
  EXPECT_EQ(both->notes.size(), 1u);
}

TEST(Obj, ColoursMayBeBytes) {
  const auto read = obj("v 0 0 0 255 0 128\nv 1 0 0 1 0 0\nv 1 1 0\nf 1 2 3\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->colours, (std::vector<Colour>{{255, 0, 128, 255}, {1, 0, 0, 255}, {255, 255, 255, 255}}));
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_NE(read->notes[0].find("0 to 255"), std::string::npos);
}

TEST(Obj, NamesWhatIsWrong) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  expectRefusal(obj(""), "m.obj: has no face");
  expectRefusal(obj(square), "m.obj: has no face");
  expectRefusal(obj(square + "f 1 2 4\n"), "face 1 names vertex 4, but there are only 3");
  expectRefusal(obj(square + "f 1 2 3\nf 1/1 2/1 3/1\n"), "face 2 names texture coordinate 1");
  expectRefusal(obj(square + "f 1 2 0\n"), "m.obj:4: face 1 has the corner '0'");
  expectRefusal(obj(square + "f 1 2 -4\n"), "face 1 has the corner '-4'");
  expectRefusal(obj(square + "f 1 2 99999999999999999999\n"), "face 1 has the corner");
  expectRefusal(obj(square + "f 1 2\n"), "face 1 has fewer than three corners");
  expectRefusal(obj(square + "v 0 nan 0\n"), "m.obj:4: vertex 4 has a coordinate that is no finite number");
  expectRefusal(obj(square + "v 0 1e400 0\n"), "vertex 4");
  expectRefusal(obj(square + "v 0 1e30 0\n"), "vertex 4 has a coordinate beyond 1e9");
  expectRefusal(obj(square + "v 0 zero 0\n"), "vertex 4 has 'zero' where a number belongs");
  expectRefusal(obj(square + "v 0 1\n"), "vertex 4");
  expectRefusal(obj(square + "vt 1 inf\nf 1 2 3\n"), "texture coordinate 1");
  std::string wide = square + "f";
  for (int i = 0; i < 2000; ++i) wide += " 1";
  expectRefusal(obj(wide), "face 1 has more than 1024 corners");
}

template <class T>
void put(std::string& out, T value, bool is_big) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (is_big) std::reverse(raw, raw + sizeof(T));
  out.append(raw, sizeof(T));
}

std::string binaryPly(const Model& model, bool is_big) {
  std::string out =
      std::string("ply\nformat ") + (is_big ? "binary_big_endian" : "binary_little_endian") +
      " 1.0\ncomment TextureFile skin.png\nelement vertex " + std::to_string(model.positions.size()) +
      "\nproperty double x\nproperty list uchar short extra\nproperty double y\nproperty double z\n"
      "property uchar red\nproperty ushort green\nproperty float blue\nproperty float s\nproperty float t\n"
      "element face " +
      std::to_string(model.faceCount()) +
      "\nproperty float area\nproperty list uint8 int32 vertex_indices\nend_header\n";
  for (const auto& p : model.positions) {
    put(out, p.x, is_big), put<uint8_t>(out, 2, is_big), put<int16_t>(out, -1, is_big), put<int16_t>(out, 7, is_big);
    put(out, p.y, is_big), put(out, p.z, is_big);
    put<uint8_t>(out, 200, is_big), put<uint16_t>(out, 257 * 100, is_big), put<float>(out, 1.0f, is_big);
    put<float>(out, 0.25f, is_big), put<float>(out, 0.5f, is_big);
  }
  for (size_t f = 0; f < model.faceCount(); ++f) {
    put<float>(out, 1.5f, is_big);
    put(out, static_cast<uint8_t>(model.face_ends[f] - model.faceBegin(f)), is_big);
    for (uint64_t c = model.faceBegin(f); c < model.face_ends[f]; ++c)
      put(out, static_cast<int32_t>(model.corners[c].vertex), is_big);
  }
  return out;
}

TEST(Ply, ReadsBothBinaryOrders) {
  const Model torus = test::makeTorus(7, 5);
  for (bool is_big : {false, true}) {
    const auto read = ply(binaryPly(torus, is_big));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->positions, torus.positions);
    EXPECT_EQ(read->face_ends, torus.face_ends);
    EXPECT_EQ(read->colours[3], (Colour{200, 100, 255, 255}));
    EXPECT_EQ(read->texture_coordinates[3], glm::dvec2(0.25, 0.5));
    EXPECT_EQ(read->materials.at(0).texture, "skin.png");
    EXPECT_EQ(read->face_materials[0], 0u);
    for (size_t c = 0; c < torus.corners.size(); ++c) EXPECT_EQ(read->corners[c].vertex, torus.corners[c].vertex);
  }
}

const std::string kHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_index\nend_header\n";

TEST(Ply, ReadsAsciiAndNamesWhatIsWrong) {
  const auto read = ply(kHeader + "0 0 0\n1 0 0\r\n1 1 0\n3 0 1 2\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->positions[2], glm::dvec3(1, 1, 0));
  expectRefusal(ply(""), "not a PLY file");
  expectRefusal(ply("ply\nformat ascii 1.0\n"), "has no end");
  expectRefusal(ply("ply\nformat morse 1.0\n"), "line 2 of its header has the unknown format 'morse'");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n"), "face 0 names vertex 3");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 1 0\n3 0 1 -1\n"), "face 0 names a vertex that is no number");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 1 0\n2 0 1\n"), "face 0 has fewer than three corners");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 nan 0\n3 0 1 2\n"),
                "vertex 2 has a coordinate that is no finite number");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 1 0\n3 0 1\n"), "face 0 is cut short");
  expectRefusal(ply(kHeader + "0 0 0\n1 0 0\n1 1 0\n200 0 1 2\n"), "longer than the file");
  expectRefusal(
      ply("ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n"
          "end_header\n1 2 3\n"),
      "promises 4000000000 of 'vertex'");
  expectRefusal(ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"), "no x, y and z");
}

const std::string kVertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

// A square of two faces whose further properties are as given.
Result<Model> facedPly(const std::string& comments, const std::string& properties, const std::string& first,
                       const std::string& second) {
  return ply("ply\nformat ascii 1.0\n" + comments +
             "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
             "property list uchar int vertex_indices\n" +
             properties + "end_header\n" + kVertices + "3 0 1 2 " + first + "\n3 0 2 3 " + second + "\n");
}

TEST(Ply, ReadsListsAndColoursOfAnyType) {
  for (const char* list :
       {"uchar int", "int uint", "uint8 uchar", "char short", "ushort ushort", "uint float", "short double"})
    for (const char* colour : {"uchar", "int", "ushort", "float", "double"}) {
      const std::string type(colour);
      const bool is_real = type == "float" || type == "double";
      std::string header =
          "ply\nformat ascii 1.0\nobj_info scanned\nelement vertex 4\nproperty double x\nproperty int y\nproperty "
          "float z\n";
      for (const char* channel : {"red", "green", "blue"}) header += "property " + type + " " + channel + "\n";
      const std::string red = is_real ? " 1 0 0.5\n" : type == "ushort" ? " 65535 0 32896\n" : " 255 0 128\n";
      const auto read = ply(header + "element face 1\nproperty list " + list + " vertex_indices\nend_header\n0 0 0" +
                            red + "1 0 0" + red + "1 1 0" + red + "0 1 0" + red + "4 0 1 2 3\n");
      ASSERT_TRUE(read.ok()) << list << ", " << colour << ": " << read.error().message;
      EXPECT_EQ(read->corners[3].vertex, 3u);
      EXPECT_EQ(read->colours[2], (Colour{255, 0, 128, 255})) << colour;
      EXPECT_EQ(read->notes, std::vector<std::string>());
    }
}

TEST(Ply, ReadsStripsOfTriangles) {
  const auto strips = [](const std::string& lists, const std::string& count) {
    return ply(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement "
        "tristrips " +
        count + "\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n" + lists);
  };
  using Faces = std::vector<std::vector<uint32_t>>;
  const auto facesOf = [](const Model& model) {
    Faces faces(model.faceCount());
    for (size_t f = 0; f < model.faceCount(); ++f)
      for (uint64_t c = model.faceBegin(f); c < model.face_ends[f]; ++c) faces[f].push_back(model.corners[c].vertex);
    return faces;
  };
  const auto one = strips("5 0 1 2 3 4\n", "1");
  ASSERT_TRUE(one.ok()) << one.error().message;
  EXPECT_EQ(facesOf(*one), (Faces{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}})) << "all counter-clockwise";
  const auto cut = strips("9 0 1 2 -1 2 1 3 -1 0\n", "1");
  ASSERT_TRUE(cut.ok()) << cut.error().message;
  EXPECT_EQ(facesOf(*cut), (Faces{{0, 1, 2}, {2, 1, 3}}));
  const auto joined = strips("3 0 1 2\n6 0 1 1 2 3 4\n", "2");
  ASSERT_TRUE(joined.ok()) << joined.error().message;
  EXPECT_EQ(facesOf(*joined), (Faces{{0, 1, 2}, {1, 2, 3}, {3, 2, 4}}));
  expectRefusal(strips("3 0 1 5\n", "1"), "face 0 names vertex 5");
  expectRefusal(strips("3 0 1 1.5\n", "1"), "face 0 names a vertex that is no number");
  expectRefusal(strips("3 0 1\n", "1"), "cut short");
}

TEST(Ply, ReadsTextureCoordinatesByCorner) {
  const std::string comments = "comment TextureFile a.png\ncomment TextureFile b c.png\n";
  const auto read = facedPly(comments, "property list uchar float texcoord\nproperty int texnumber\n",
                             "6 0 0 1 0 1 1 1", "6 0.25 0 1 1 0 1 0");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->texture_coordinates, (std::vector<glm::dvec2>{{0, 0}, {1, 0}, {1, 1}, {0.25, 0}, {1, 1}, {0, 1}}));
  EXPECT_EQ(read->corners[3].texture, 3u);
  EXPECT_EQ(read->corners[3].vertex, 0u);
  EXPECT_EQ(read->face_materials, (std::vector<uint32_t>{1, 0}));
  EXPECT_EQ(read->materials.at(1).texture, "b c.png");
  EXPECT_EQ(read->notes, std::vector<std::string>());

  const auto bare = facedPly(comments, "property list uchar float texcoord\n", "0", "5 1 2 3 4 5");
  ASSERT_TRUE(bare.ok()) << bare.error().message;
  EXPECT_EQ(bare->corners[0].texture, kNoIndex);
  EXPECT_EQ(bare->notes,
            std::vector<std::string>{"texture coordinates of faces that are not two a corner left out: 1"});
  const auto imageless = facedPly("", "property list uchar float texcoord\n", "6 0 0 1 0 1 1", "0");
  ASSERT_TRUE(imageless.ok()) << imageless.error().message;
  ASSERT_EQ(imageless->notes.size(), 1u);
  EXPECT_NE(imageless->notes[0].find("no 'comment TextureFile'"), std::string::npos);
}

TEST(Ply, ReadsColoursOfFaces) {
  const auto bytes =
      facedPly("", "property uchar red\nproperty uchar green\nproperty uchar blue\n", "255 0 0", "0 128 0");
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  EXPECT_EQ(bytes->face_colours, (std::vector<Colour>{{255, 0, 0, 255}, {0, 128, 0, 255}}));
  EXPECT_TRUE(bytes->colours.empty());
  const auto shares = facedPly("", "property float r\nproperty float g\nproperty float b\nproperty float a\n",
                               "1 0 0.5 0.5", "0 1 0 1");
  ASSERT_TRUE(shares.ok()) << shares.error().message;
  EXPECT_EQ(shares->face_colours, (std::vector<Colour>{{255, 0, 128, 128}, {0, 255, 0, 255}}));
  const auto large = facedPly("", "property float r\nproperty float g\nproperty float b\n", "255 0 128", "0 1 0");
  ASSERT_TRUE(large.ok()) << large.error().message;
  EXPECT_EQ(large->face_colours, (std::vector<Colour>{{255, 0, 128, 255}, {0, 1, 0, 255}}));
  EXPECT_EQ(large->notes.size(), 1u);
}

TEST(Ply, ReadsColoursByOtherNames) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"red", "green", "blue"},
                                                {"diffuse_red", "diffuse_green", "diffuse_blue"},
                                                {"r", "g", "b"}}) {
    std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    for (const std::string& name : names) header += "property uchar " + name + "\n";
    const auto read = ply(header +
                          "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n"
                          "1 0 0 4 5 6\n1 1 0 7 8 9\n3 0 1 2\n");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->colours, (std::vector<Colour>{{1, 2, 3, 255}, {4, 5, 6, 255}, {7, 8, 9, 255}})) << names[0];
    EXPECT_EQ(read->notes, std::vector<std::string>());
  }
}

TEST(Ply, WhatIsNotTakenIsCounted) {
  const auto read =
      ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
          "property float nx\nproperty float quality\nelement face 1\nproperty list uchar int vertex_indices\n"
          "property int flags\nelement edge 2\nproperty int vertex1\nproperty list uchar int more\n"
          "end_header\n0 0 0 1 5\n1 0 0 1 5\n1 1 0 1 5\n3 0 1 2 7\n1 0\n2 2 8 9\n1 2\n\n");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->notes, (std::vector<std::string>{
                             "bytes behind the last element left out: 6", "elements 'edge' left out: 2",
                             "property 'flags' of 'face' left out: 1", "property 'quality' of 'vertex' left out: 3"}));
}

TEST(Ply, ReadsAnyEncodingAndLineEnds) {
  const Model torus = test::makeTorus(7, 5);
  const std::string binary = binaryPly(torus, false);
  const size_t data = binary.find("end_header\n") + 11;
  // The first byte of the data is a line feed for one x of many.
  std::string header = binary.substr(0, data), mac = header, dos;
  for (char& c : mac) c = c == '\n' ? '\r' : c;
  for (const char c : header) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::string feed = binary.substr(data);
  feed[0] = '\n';
  for (const std::string& begin : {header, mac, dos, "\xef\xbb\xbf" + header}) {
    const auto read = ply(begin + feed);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(std::bit_cast<uint64_t>(read->positions[0].x) & 0xff, 10u);
    EXPECT_EQ(read->positions[1], torus.positions[1]);
  }
  const auto wide_text = ply(wide(kHeader + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n", false));
  ASSERT_TRUE(wide_text.ok()) << wide_text.error().message;
  EXPECT_EQ(wide_text->positions[2], glm::dvec3(1, 1, 0));
}

// Whatever is changed or cut off, the readers end in a model or an error, and read nothing that is not there.
TEST(Models, DamagedFilesEndInAModelOrAnError) {
  constexpr uint64_t kSeed = 9;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  const Model torus = test::makeTorus(5, 4);
  const std::string files[] = {test::toObj(torus), binaryPly(torus, false), binaryPly(torus, true)};
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = files[i % 3];
    for (uint64_t changes = rng.below(4); changes > 0; --changes)
      bytes[rng.below(bytes.size())] = static_cast<char>(rng.next());
    if (rng.below(2) == 0) bytes.resize(rng.below(bytes.size()));
    const std::vector<char> exact(bytes.begin(), bytes.end());
    const auto read = i % 3 == 0 ? obj({exact.data(), exact.size()})
                                 : parsePly({reinterpret_cast<const uint8_t*>(exact.data()), exact.size()}, "m.ply");
    refused += !read.ok();
    if (!read.ok()) continue;
    for (const Corner& corner : read->corners) ASSERT_LT(corner.vertex, read->positions.size());
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 3000);
}

TEST(Models, FilesThatAreNotThereOrOfAnotherKindAreNamed) {
  for (const char* path : {"missing.obj", "missing.PLY", "missing.Stl", "model.fbx", ""}) {
    const auto read = readModel(path);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find(path), std::string::npos);
  }
}

}  // namespace
}  // namespace foreland::terrain
