// MARTINI (https://github.com/mapbox/martini, index.js of version 0.2.0, ISC licence) transcribed to plain C++,
// function by function, for the JavaScript one is no measure of its algorithm. It extracts right-triangulated meshes of
// one error in metres for the whole of a square of 2^k + 1 samples; meshes are the JavaScript one's, to the triangle.
// Unlike it, it reuses the memory of its meshes.
//
// One owner. 28 bytes a sample, as the original.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace foreland::lab {

// What depends on the size alone: every triangle's hypotenuse, by its number in the implicit binary tree.
struct MartiniTables {
  explicit MartiniTables(uint32_t grid_size);

  uint32_t grid_size;
  uint32_t triangles, parent_triangles;
  std::vector<uint16_t> coords;  // ax, ay, bx, by of each triangle
};

class PlainMartini {
 public:
  struct Mesh {
    std::vector<uint16_t> vertices;   // x, y in samples
    std::vector<uint32_t> triangles;  // three vertices each
    size_t triangleCount() const { return triangles.size() / 3; }
  };

  // `heights` in metres, row by row. Computes the errors of all triangles, bottom up.
  PlainMartini(const MartiniTables& tables, std::vector<float> heights);

  double largestError_m() const;
  // Valid until the next call.
  const Mesh& mesh(double max_error_m);
  // A part of what mesh() does.
  void clearIndices();
  // Largest difference in height between the last mesh and the samples.
  double trueError_m() const;

 private:
  struct Corners {
    uint32_t ax, ay, bx, by, cx, cy;
  };
  bool isSplit(const Corners& t) const;
  void count(const Corners& t);
  void write(const Corners& t);

  uint32_t size_;
  std::vector<float> heights_, errors_;
  std::vector<uint32_t> indices_;  // of vertices, from 1, by sample; 0: in no triangle
  Mesh mesh_;
  double max_error_m_ = 0;
  uint32_t vertex_count_ = 0;
  size_t triangle_count_ = 0, written_ = 0;
};

}  // namespace foreland::lab
