// foreland-verify: checks a scene or surface file and says what it checked. Exit codes: 0 sound, 2 damaged or neither.
#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cstdio>
#include <string>

#include "terrain/store/verify.h"
#include "terrain/surface_store/mapped_surface.h"

namespace {

using namespace foreland;

// What is checked of base vertices and of nodes.
struct Checks {
  const char* base;
  const char* nodes;
};
constexpr Checks kTerrainChecks{
    "heights within the scene's range",
    "heights within range, errors cover the children's, spheres hold corners and the children's spheres"};
constexpr Checks kSurfaceChecks{"positions within the surface's box",
                                "positions within the box, spheres, cones and error shapes hold the children's"};

int report(const std::string& path, const Checks& checks, const terrain::VerifyReport& found) {
  std::printf("header, sizes and table of checksums agree\n");
  std::printf("%" PRIu64 " blocks: contents against their checksums\n", found.blocks);
  std::printf("%" PRIu64 " base vertices: %s\n", found.base_vertices, checks.base);
  std::printf("%" PRIu64 " nodes: %s\n", found.nodes, checks.nodes);
  std::printf("%" PRIu64 " unused slots: zero\n", found.padding);
  if (found.texels > 0)
    std::printf("%" PRIu64 " texels: the same on both sides of base edges, gutters as neighbours have them\n",
                found.texels);
  if (found.sound()) {
    std::printf("%s: sound\n", path.c_str());
    return 0;
  }
  for (const std::string& fault : found.first_faults)
    std::fprintf(stderr, "foreland verify: %s: %s\n", path.c_str(), fault.c_str());
  std::fprintf(stderr, "foreland verify: %s: %" PRIu64 " faults; build or copy the scene again\n", path.c_str(),
               found.faults);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::string path;
  unsigned threads = 0;
  CLI::App app("Checks a scene or surface file's checksums and invariants.", "foreland verify");
  app.add_option("SCENE", path, "A file made by `foreland build` or `foreland remesh`")->required();
  app.add_option("--threads", threads, "Worker threads; 0 for one per processor")->check(CLI::Range(0u, 1024u));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) { return app.exit(error) == 0 ? 0 : 2; }
  const bool is_surface = terrain::isSurfaceFile(path);
  const auto found = is_surface ? terrain::verifySurface(path, threads) : terrain::verifyScene(path, threads);
  if (!found.ok()) {
    std::fprintf(stderr, "foreland verify: %s\n", found.error().message.c_str());
    return 2;
  }
  return report(path, is_surface ? kSurfaceChecks : kTerrainChecks, *found);
}
