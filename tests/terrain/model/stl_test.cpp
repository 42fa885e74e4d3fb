// STL: both forms say the same, and what is wrong is named.
#include <gtest/gtest.h>

#include "base/rng.h"
#include "terrain/model/read_model.h"
#include "tests/support/damage.h"
#include "tests/support/models.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

Result<Model> stl(const std::string& text) {
  const std::vector<uint8_t> exact(text.begin(), text.end());
  return parseStl(exact, "m.stl");
}
void expectRefusal(const std::string& bytes, const std::string& words) {
  const auto model = stl(bytes);
  ASSERT_FALSE(model.ok()) << words;
  EXPECT_NE(model.error().message.find(words), std::string::npos) << model.error().message;
}
std::vector<uint32_t> verticesOf(const Model& model) {
  std::vector<uint32_t> vertices;
  for (const Corner& corner : model.corners) vertices.push_back(corner.vertex);
  return vertices;
}

std::vector<glm::dvec3> rounded(std::vector<glm::dvec3> positions) {
  for (glm::dvec3& p : positions) p = glm::dvec3(glm::vec3(p));
  return positions;
}

TEST(Stl, BothFormsAreTheModelWithOneVertexAtEachPosition) {
  for (const Model& model :
       {test::inTriangles(test::makeCube(2)), test::makeSphere(3), test::inTriangles(test::makePatch(5))}) {
    const auto text = stl(test::toTextStl(model)), binary = stl(test::toBinaryStl(model));
    ASSERT_TRUE(text.ok()) << text.error().message;
    ASSERT_TRUE(binary.ok()) << binary.error().message;
    EXPECT_EQ(rounded(text->positions), binary->positions);  // text may have more digits than a float
    EXPECT_EQ(verticesOf(*text), verticesOf(*binary));
    EXPECT_EQ(text->face_ends, model.face_ends);
    for (size_t c = 0; c < model.corners.size(); ++c)
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_EQ(binary->positions[binary->corners[c].vertex][axis],
                  static_cast<float>(model.positions[model.corners[c].vertex][axis]));
  }
  EXPECT_EQ(stl(test::toBinaryStl(test::inTriangles(test::makeCube(2))))->positions.size(), 26u);
}

TEST(Stl, ReadsWhatExportersWrite) {
  const Model sphere = test::makeSphere(1);
  const auto solid = stl(test::toBinaryStl(sphere, "solid made by a program that did not read the format"));
  ASSERT_TRUE(solid.ok()) << solid.error().message;
  EXPECT_EQ(solid->faceCount(), sphere.faceCount());
  const auto trailed = stl(test::toBinaryStl(sphere) + "trailer");
  ASSERT_TRUE(trailed.ok()) << trailed.error().message;
  const auto loud =
      stl("solid\r\nFACET NORMAL 0 0 1\r\nOUTER LOOP\r\nVERTEX 0 0 -0\r\nVERTEX 1e0 0 0\r\nVERTEX 0 +1 0\r\n"
          "ENDLOOP\r\nENDFACET\r\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex -1 0 0\n"
          "endloop\nendfacet\nendsolid\n");
  ASSERT_TRUE(loud.ok()) << loud.error().message;
  EXPECT_EQ(verticesOf(*loud), (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}));
}

TEST(Stl, TextIsKnownHoweverItBegins) {
  const Model sphere = test::makeSphere(1);
  const std::string text = test::toTextStl(sphere);
  ASSERT_TRUE(text.starts_with("solid")) << text.substr(0, 20);
  const std::string body = text.substr(text.find('\n'));
  std::string loud = text, mac = text, wide = "\xff\xfe";
  for (char& c : loud) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (char& c : mac) c = c == '\n' ? '\r' : c;
  for (const char c : text) wide += c, wide += '\0';
  for (const std::string& form : {" " + text, "\t\r\n " + text, "\xef\xbb\xbf" + text, "solid" + body,
                                  "solid " + std::string(200, 'x') + body, body, loud, mac, wide}) {
    const auto model = stl(form);
    ASSERT_TRUE(model.ok()) << form.substr(0, 20) << ": " << model.error().message;
    EXPECT_EQ(model->faceCount(), sphere.faceCount()) << form.substr(0, 20);
  }
}

TEST(Stl, BinaryThatBeginsAsTextMayBePadded) {
  const Model sphere = test::makeSphere(1);
  for (const char* header : {"solid", " solid part", "SOLID facet", "solid\n facet normal 0 0 1"})
    for (const size_t padding : {0, 1, 16, 500}) {
      const auto model = stl(test::toBinaryStl(sphere, header) + std::string(padding, '\0'));
      ASSERT_TRUE(model.ok()) << header << ", " << padding << ": " << model.error().message;
      EXPECT_EQ(model->faceCount(), sphere.faceCount());
    }
  const std::string whole = test::toBinaryStl(sphere, "solid part");
  expectRefusal(whole.substr(0, whole.size() - 60), "promises 32 triangles, but ends after 30");
}

TEST(Stl, ReadsSeveralSolidsAndCountsWhatFollows) {
  const Model sphere = test::makeSphere(1);
  const std::string text = test::toTextStl(sphere);
  std::string loud = text, apart = text;
  for (char& c : loud) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (size_t at = 0; (at = apart.find("endloop", at)) != std::string::npos; at += 8) apart.replace(at, 7, "end loop");
  for (const std::string& form :
       {text + text, text + "\n\n" + loud, apart + text, text + text + std::string(3, '\0'), text + loud + "\x1a"}) {
    const auto model = stl(form);
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->faceCount(), 2 * sphere.faceCount());
    EXPECT_EQ(model->positions.size(), sphere.positions.size()) << "the same places are the same vertices";
    EXPECT_EQ(model->notes, std::vector<std::string>());
  }
  const auto followed = stl(text + "<html>\nnot found\n");
  ASSERT_TRUE(followed.ok()) << followed.error().message;
  EXPECT_EQ(followed->notes, std::vector<std::string>{"lines that are of no kind of STL left out: 2"});
  const auto binary = stl(test::toBinaryStl(sphere) + "made by hand");
  ASSERT_TRUE(binary.ok()) << binary.error().message;
  EXPECT_EQ(binary->faceCount(), sphere.faceCount());
  EXPECT_EQ(binary->notes, std::vector<std::string>{"bytes behind the last triangle left out: 12"});
}

// Programs that write as they go do not know the number when they write the header.
TEST(Stl, ReadsAllTrianglesWhereNoNumberIsGiven) {
  const Model sphere = test::makeSphere(1);
  for (const char* number : {"\0\0\0\0", "\xff\xff\xff\xff"}) {
    std::string bytes = test::toBinaryStl(sphere);
    bytes.replace(80, 4, number, 4);
    const auto model = stl(bytes);
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_EQ(model->faceCount(), sphere.faceCount());
    EXPECT_EQ(model->notes, std::vector<std::string>{"gives no number of triangles; all 32 are read"});
    EXPECT_FALSE(stl(bytes + "x").ok());
  }
}

// Two conventions for the two bytes that the format leaves open.
TEST(Stl, ReadsColoursOfTriangles) {
  const Model sphere = test::makeSphere(0);
  const auto coloured = [&](std::string bytes, uint16_t first, uint16_t others) {
    for (size_t t = 0; t < sphere.faceCount(); ++t) {
      const uint16_t attribute = t == 0 ? first : others;
      bytes[84 + 50 * t + 48] = static_cast<char>(attribute & 0xff);
      bytes[84 + 50 * t + 49] = static_cast<char>(attribute >> 8);
    }
    return stl(bytes);
  };
  const auto viscam = coloured(test::toBinaryStl(sphere), 0x8000 | 31 << 10, 0);
  ASSERT_TRUE(viscam.ok());
  ASSERT_EQ(viscam->face_colours.size(), sphere.faceCount());
  EXPECT_EQ(viscam->face_colours[0], (Colour{255, 0, 0, 255}));
  EXPECT_EQ(viscam->face_colours[1], (Colour{255, 255, 255, 255}));
  const auto magics = coloured(test::toBinaryStl(sphere, "COLOR=\x0a\x14\x1e\xff"), 31 << 10, 0x8000);
  ASSERT_TRUE(magics.ok());
  ASSERT_EQ(magics->face_colours.size(), sphere.faceCount());
  EXPECT_EQ(magics->face_colours[0], (Colour{0, 0, 255, 255}));
  EXPECT_EQ(magics->face_colours[1], (Colour{10, 20, 30, 255}));
  const auto neither = coloured(test::toBinaryStl(sphere), 0x2020, 0x2020);
  ASSERT_TRUE(neither.ok());
  EXPECT_TRUE(neither->face_colours.empty());
  EXPECT_EQ(neither->notes, std::vector<std::string>{"attributes of triangles that are no colours left out: 8"});
  EXPECT_TRUE(stl(test::toBinaryStl(sphere))->face_colours.empty());
}

TEST(Stl, NamesWhatIsWrong) {
  const std::string sphere = test::toBinaryStl(test::makeSphere(1));
  expectRefusal("", "m.stl: is no STL file");
  expectRefusal("<html></html>", "is no STL file");
  expectRefusal(sphere.substr(0, sphere.size() - 1), "promises 32 triangles, but ends after 31");
  expectRefusal(sphere.substr(0, 84), "promises 32 triangles, but ends after 0");
  std::string infinite = sphere;
  infinite.replace(84 + 12, 4, "\x00\x00\x80\x7f", 4);
  expectRefusal(infinite, "vertex 1 has a coordinate that is no finite number");
  const std::string begin = "solid\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
  expectRefusal(begin, "ends within a facet");
  expectRefusal(begin + "endloop\n", "m.stl:5: face 1 has fewer than three corners");
  expectRefusal(begin + "vertex 0 x 0\n", "m.stl:5: has 'x' where a number belongs");
  expectRefusal("solid\nendsolid\n", "has no face");
}

TEST(Stl, DamagedFilesEndInAModelOrAnError) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const std::vector<std::string> files{test::toBinaryStl(test::makeSphere(1)), test::toTextStl(test::makeSphere(1))};
  const int refused = test::countRefused(files, 2000, 2, rng, [](const std::string& bytes) { return stl(bytes); });
  EXPECT_GT(refused, 300);
  EXPECT_LT(refused, 2000);
}

}  // namespace
}  // namespace foreland::terrain
