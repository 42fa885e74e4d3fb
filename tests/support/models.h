// Polygon models made by formula, and their text as the files that the readers read.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "terrain/model/model.h"

namespace foreland::test {

inline terrain::Model makeModel(std::vector<glm::dvec3> positions, const std::vector<std::vector<uint32_t>>& faces) {
  terrain::Model model;
  model.name = "made";
  model.positions = std::move(positions);
  for (const auto& face : faces) {
    for (uint32_t v : face) model.corners.push_back({v, terrain::kNoIndex});
    model.face_ends.push_back(model.corners.size());
    model.face_materials.push_back(terrain::kNoIndex);
  }
  return model;
}

// Radius 1; 8 * 4^halvings triangles of an octahedron.
inline terrain::Model makeSphere(int halvings) {
  std::vector<glm::dvec3> p{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::vector<uint32_t>> faces{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                           {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (; halvings > 0; --halvings) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(p.size()));
      if (is_new) p.push_back(glm::normalize(p[a] + p[b]));
      return at->second;
    };
    std::vector<std::vector<uint32_t>> finer;
    for (const auto& f : faces) {
      const uint32_t ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {ab, f[1], bc}, {ca, bc, f[2]}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  return makeModel(std::move(p), faces);
}

// Quadrangles on a grid of `columns` x `rows`, closed in either direction if asked, at the places that `at` gives for
// parameters from 0 to 1.
template <class At>
terrain::Model makeGrid(uint32_t columns, uint32_t rows, std::array<bool, 2> closes, const At& at) {
  const uint32_t across = columns + (closes[0] ? 0 : 1), up = rows + (closes[1] ? 0 : 1);
  std::vector<glm::dvec3> p;
  for (uint32_t y = 0; y < up; ++y)
    for (uint32_t x = 0; x < across; ++x) p.push_back(at(double(x) / columns, double(y) / rows));
  std::vector<std::vector<uint32_t>> faces;
  const auto vertex = [&](uint32_t x, uint32_t y) { return y % up * across + x % across; };
  for (uint32_t y = 0; y < rows; ++y)
    for (uint32_t x = 0; x < columns; ++x)
      faces.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
  return makeModel(std::move(p), faces);
}

// Radii 1 and 0.4.
inline terrain::Model makeTorus(uint32_t around, uint32_t through) {
  return makeGrid(around, through, {true, true}, [](double u, double v) {
    const double a = 2 * std::numbers::pi * u, b = 2 * std::numbers::pi * v, r = 1 + 0.4 * std::cos(b);
    return glm::dvec3(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b));
  });
}

// A bumpy square of side 1 with a border.
inline terrain::Model makePatch(uint32_t side) {
  return makeGrid(side, side, {false, false},
                  [](double u, double v) { return glm::dvec3(u, v, 0.1 * std::sin(5 * u) * std::cos(4 * v)); });
}

// Twelve sharp edges: a cube of side 1, each side of cells x cells quadrangles. Sides have vertices of their own where
// they meet, as exporters of flat shading write them.
inline terrain::Model makeCube(uint32_t cells) {
  std::vector<glm::dvec3> p;
  std::vector<std::vector<uint32_t>> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (int sign : {0, 1}) {
      const auto begin = static_cast<uint32_t>(p.size());
      for (uint32_t y = 0; y <= cells; ++y)
        for (uint32_t x = 0; x <= cells; ++x) {
          glm::dvec3 at(sign);
          at[(axis + 1) % 3] = double(sign ? x : y) / cells;
          at[(axis + 2) % 3] = double(sign ? y : x) / cells;
          p.push_back(at);
        }
      const auto vertex = [&](uint32_t x, uint32_t y) { return begin + y * (cells + 1) + x; };
      for (uint32_t y = 0; y < cells; ++y)
        for (uint32_t x = 0; x < cells; ++x)
          faces.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
    }
  return makeModel(std::move(p), faces);
}

inline std::string toObj(const terrain::Model& model) {
  std::ostringstream out;
  out.precision(17);
  for (const auto& p : model.positions) out << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const auto& t : model.texture_coordinates) out << "vt " << t.x << ' ' << t.y << '\n';
  for (size_t f = 0; f < model.faceCount(); ++f) {
    out << 'f';
    for (uint64_t c = model.faceBegin(f); c < model.face_ends[f]; ++c) {
      out << ' ' << model.corners[c].vertex + 1;
      if (model.corners[c].texture != terrain::kNoIndex) out << '/' << model.corners[c].texture + 1;
    }
    out << '\n';
  }
  return out.str();
}

inline void appendFloat(std::string& out, double value) {
  const auto bits = std::bit_cast<uint32_t>(static_cast<float>(value));
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(bits >> shift & 255);
}

// A model of triangles alone; its normals are zero.
inline std::string toBinaryStl(const terrain::Model& model, const std::string& header = "made") {
  std::string out = header;
  out.resize(80, ' ');
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(model.faceCount() >> shift & 255);
  for (size_t f = 0; f < model.faceCount(); ++f) {
    out.append(12, '\0');
    for (size_t k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) appendFloat(out, model.positions[model.corners[3 * f + k].vertex][axis]);
    out.append(2, '\0');
  }
  return out;
}

inline std::string toTextStl(const terrain::Model& model) {
  std::ostringstream out;
  out.precision(9);
  out << "solid made\n";
  for (size_t f = 0; f < model.faceCount(); ++f) {
    out << "  facet normal 0 0 0\n    outer loop\n";
    for (uint64_t c = model.faceBegin(f); c < model.face_ends[f]; ++c) {
      const glm::dvec3& p = model.positions[model.corners[c].vertex];
      out << "      vertex " << static_cast<float>(p.x) << ' ' << static_cast<float>(p.y) << ' '
          << static_cast<float>(p.z) << '\n';
    }
    out << "    endloop\n  endfacet\n";
  }
  out << "endsolid made\n";
  return out.str();
}

// Each polygon as triangles around its first corner.
inline terrain::Model inTriangles(const terrain::Model& model) {
  std::vector<std::vector<uint32_t>> faces;
  for (size_t f = 0; f < model.faceCount(); ++f)
    for (uint64_t c = model.faceBegin(f) + 1; c + 1 < model.face_ends[f]; ++c)
      faces.push_back({model.corners[model.faceBegin(f)].vertex, model.corners[c].vertex, model.corners[c + 1].vertex});
  return makeModel(model.positions, faces);
}

}  // namespace foreland::test
