// `foreland sums SCENE`: writes beside a scene file the checksums that a server needs which reads it from a store
// (`foreland serve https://...`). Exit codes: 0 done, 2 anything else, with a line on stderr; nothing half-written
// stays.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "terrain/store/distant/sums.h"
#include "terrain/store/file/new_file.h"
#include "terrain/store/mapped_scene.h"

namespace {

using namespace foreland;

int fail(const Error& error) {
  std::fprintf(stderr, "foreland sums: %s\n", error.message.c_str());
  return 2;
}

Status write(const Bytes& bytes, const std::filesystem::path& output) {
  auto file = terrain::NewFile::create(output, bytes.size(), terrain::FileMapping::kNone);
  if (!file) return file.error();
  if (Status s = file->put(0, bytes); !s.ok()) return s;
  return file->finish();
}

int makeSums(const std::filesystem::path& scene, std::filesystem::path output, uint64_t chunk_bytes) {
  if (output.empty()) output = terrain::sumsBeside(scene.string());
  if (Status s = apps::checkOutput(output, "file of checksums"); !s.ok()) return fail(s.error());
  if (Status s = apps::checkApart(output, scene, "the scene"); !s.ok()) return fail(s.error());
  if (const auto opened = terrain::MappedScene::open(scene); !opened) return fail(opened.error());
  const auto sums = terrain::sumsOf(scene, chunk_bytes);
  if (!sums) return fail(sums.error());
  const Bytes bytes = encode(*sums);
  if (Status s = write(bytes, output); !s.ok()) return fail(s.error());
  std::printf("%s: %zu checksums of %llu KiB each, %zu bytes, of scene %016llx\n", output.c_str(), sums->sums.size(),
              static_cast<unsigned long long>(chunk_bytes >> 10), bytes.size(),
              static_cast<unsigned long long>(sums->scene_id));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path scene, output;
  unsigned chunk_kib = terrain::SceneSums::kUsualChunk >> 10;
  CLI::App app("Writes the checksums of a scene file that is to be served from a store.", "foreland sums");
  app.add_option("SCENE", scene, "scene file made by `foreland build`")->type_name(apps::file("SCENE.fls"))->required();
  app.add_option("-o,--output", output, "the file to write; by default SCENE.fls.sums, where servers look for it")
      ->type_name(apps::file("FILE"));
  app.add_option("--chunk-kib", chunk_kib,
                 "KiB that servers fetch and check at a time, a power of two; less is there sooner, more is fewer "
                 "requests")
      ->type_name(apps::whole("KIB"))
      ->check(apps::within(4, 16384))
      ->capture_default_str();
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv, {{"before the two files are copied to a store", "foreland sums earth.fls"}});
  if (exit_code) return *exit_code;
  return makeSums(scene, output, uint64_t{chunk_kib} << 10);
}
