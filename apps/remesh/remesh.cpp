// foreland-remesh: a polygon model in, one surface file out, and a report of how far it is from the model. Exit codes:
// 0 done, 2 anything else, with a line on stderr; nothing half-written stays.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "apps/options/command_line.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/remesh/remesh_poses.h"
#include "apps/remesh/remesh_report.h"
#include "apps/stop_signal.h"
#include "terrain/model/image.h"
#include "terrain/model/origin.h"
#include "terrain/model/read_model.h"
#include "terrain/remesh/paint/paint.h"
#include "terrain/remesh/remesh.h"
#include "terrain/remesh/remeshed_surface.h"
#include "terrain/remesh/solids/find_solids.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface_store/write_surface.h"

namespace {

using namespace foreland;
using Clock = std::chrono::steady_clock;

using Textures = std::vector<std::shared_ptr<const terrain::Image>>;

struct Arguments {
  std::filesystem::path input, output;
  terrain::RemeshOptions remesh;
  std::optional<double> step;
  std::optional<uint32_t> texels;
  proto::MeshRule rule = proto::MeshRule::kQuadrisection;
  apps::ModelReading reading;
  apps::ForeignFiles foreign;
  std::string origin = "auto";
  std::vector<std::string> poses;
  bool json = false, strict = false;
};

void describeShape(CLI::App& app, Arguments& arguments) {
  app.add_option("MODEL", arguments.input,
                 "a polygon model: .obj, .ply, .stl (text or binary), .glb or .gltf, closed or with borders; what is "
                 "not read of it is a note")
      ->type_name(apps::file("MODEL"))
      ->required();
  app.add_option("-o,--output", arguments.output, "the surface file to write")
      ->type_name(apps::file("SURFACE.fls"))
      ->required();
  app.add_option("--levels", arguments.remesh.levels,
                 "levels of refinement: how often each base triangle is cut into four")
      ->type_name(apps::whole("J"))
      ->check(apps::within(1, terrain::Lattice::kMaxLevels))
      ->capture_default_str();
  app.add_option("--base-triangles", arguments.remesh.base_triangles, "about how many triangles the base mesh has")
      ->type_name(apps::whole("N"))
      ->check(apps::within(4u, proto::BaseMesh::kMaxFaces))
      ->capture_default_str();
  static const std::map<std::string, proto::MeshRule> rules{{"quadrisection", proto::MeshRule::kQuadrisection},
                                                            {"bisection", proto::MeshRule::kBisection}};
  app.add_option_function<std::string>(
         "--rule", [&](const std::string& name) { arguments.rule = rules.at(name); },
         "how triangles are cut: into four; or, after a vertex is added in the middle of each face, in two, twice a "
         "level")
      ->check(apps::oneOf({"quadrisection", "bisection"}))
      ->default_str("quadrisection");
  app.add_option("--attempts", arguments.remesh.attempts,
                 "base meshes tried, each learning from the one before: more take longer and come closer")
      ->type_name(apps::whole("K"))
      ->check(apps::within(1, 1000))
      ->capture_default_str();
  app.add_option(
         "--step", arguments.step,
         "positions are stored as multiples of this, in the model's units; by default a sixteenth of the detail "
         "that the finest level adds, but at least a millionth of the model's size")
      ->type_name(apps::number("S"))
      ->check(apps::above(0));
}

void describeModel(CLI::App& app, Arguments& arguments) {
  static const std::map<std::string, terrain::UpAxis> axes{{"y", terrain::UpAxis::kY}, {"z", terrain::UpAxis::kZ}};
  app.add_option_function<std::string>(
         "--up", [&](const std::string& name) { arguments.reading.up = axes.at(name); },
         "which axis of the model points up; the surface's is z. By default y for glTF, as its format has it, else z")
      ->check(apps::oneOf({"y", "z"}));
  app.add_option(
         "--texels", arguments.texels,
         "intervals of colour along a base edge, rounded up to a multiple of four; by default as fine as the model's "
         "colours; 0 for none")
      ->type_name(apps::whole("T"))
      ->check(apps::within(0u, proto::AtlasLayout::kMaxPixels));
  app.add_option(
         "--origin", arguments.origin,
         "the point of the model's coordinates, z up, that becomes the surface's (0, 0, 0): auto: one of its own "
         "for a model far from there, as in the coordinates of a map; file: as in the file. The surface's file "
         "keeps it, and `foreland build --object SURFACE.fls@here` uses it")
      ->type_name(apps::text("auto|file|X,Y,Z"))
      ->capture_default_str();
  app.add_option("--pose", arguments.poses,
                 "the model at a date: the surface changes in time from the first date to the last. FILE has the faces "
                 "and vertices of MODEL, whose positions only decide where the base mesh lies")
      ->type_name(apps::text("YYYY-MM-DD=FILE"))
      ->allow_extra_args(false);
  app.add_flag("--strict", arguments.strict,
               "refuse a model that is no surface, and name the fault, instead of repairing it with a note");
}

void describeRun(CLI::App& app, Arguments& arguments) {
  app.add_option("--threads", arguments.remesh.threads, "worker threads; 0 for one per processor")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0u, 1024u))
      ->capture_default_str();
  app.add_flag("--json", arguments.json, "print the report as JSON");
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland remesh: %s\n", error.message.c_str());
  return 2;
}

Status checkOutput(const Arguments& arguments) {
  if (Status s = apps::checkOutput(arguments.output, "surface file"); !s.ok()) return s;
  return apps::checkApart(arguments.output, arguments.input, "the model");
}

// Of --origin. Error if it is none of its forms.
Result<glm::dvec3> chooseOrigin(const std::string& text, const terrain::Model& model) {
  if (text == "auto") return terrain::ownOrigin(model);
  if (text == "file") return glm::dvec3(0);
  glm::dvec3 origin(0);
  int end = -1;
  const bool is_read = std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &origin.x, &origin.y, &origin.z, &end) == 3 &&
                       end == static_cast<int>(text.size());
  for (int axis = 0; axis < 3; ++axis)
    if (!is_read || !(std::fabs(origin[axis]) <= terrain::kMaxCoordinate))
      return Error{ErrorCode::kInvalidArgument,
                   "--origin " + text + ": give auto, file or three numbers X,Y,Z of at most 1e9"};
  return origin;
}

std::string originNote(const glm::dvec3& origin, const std::filesystem::path& output) {
  char numbers[120];
  std::snprintf(numbers, sizeof(numbers), "(%.12g, %.12g, %.12g)", origin.x, origin.y, origin.z);
  return std::string("its origin is ") + numbers + " of the model's coordinates, which lie far from zero; --object " +
         output.filename().string() +
         "@here places it there in a scene of that reference system, --origin file leaves it as it is";
}

// For a texture that cannot be read, a note is made, and the material's own colour is used. Materials that share an
// image of the model's file share its pixels.
Textures readTextures(const terrain::Model& model, std::vector<std::string>& notes) {
  Textures textures(model.materials.size());
  std::map<const Bytes*, std::shared_ptr<const terrain::Image>> decoded;
  for (size_t i = 0; i < textures.size(); ++i) {
    const terrain::Material& material = model.materials[i];
    if (material.texture.empty()) continue;
    if (const auto found = decoded.find(material.embedded.get()); material.embedded && found != decoded.end()) {
      textures[i] = found->second;
      continue;
    }
    auto image = material.embedded ? terrain::decodeImage(*material.embedded, material.texture.string())
                                   : terrain::readImage(material.texture);
    if (image.ok())
      textures[i] = std::make_shared<const terrain::Image>(std::move(image).value());
    else
      notes.push_back("without the texture of material '" + material.name + "': " + image.error().message);
    if (material.embedded) decoded[material.embedded.get()] = textures[i];
  }
  return textures;
}

// What the file holds of a surface besides its shape.
struct Finished {
  terrain::Painted painted;
  terrain::SceneOrigin about;
};

Status addColours(const Arguments& arguments, const terrain::Model& model, const terrain::Original& original,
                  const terrain::Remeshed& remeshed, Finished& finished) {
  const Textures textures = readTextures(model, finished.about.notes);
  const terrain::Palette palette{model, textures};
  if (!terrain::hasColours(palette) || arguments.texels == 0u) return {};
  const uint32_t side = arguments.texels.value_or(
      terrain::chooseSide(palette, original, static_cast<uint32_t>(remeshed.base_faces.size())));
  auto painted = terrain::paint(palette, original, remeshed, side, arguments.remesh.threads);
  if (!painted.ok()) return painted.error();
  finished.painted = std::move(painted).value();
  return {};
}

// All files that the command names, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const Arguments& arguments) {
  std::vector<std::filesystem::path> files{arguments.input};
  for (const std::string& text : arguments.poses) files.emplace_back(text.substr(text.find('=') + 1));
  return files;
}

int remesh(Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  auto model = apps::readUpright(arguments.input, arguments.reading);
  if (!model.ok()) return fail(model.error());
  const auto origin = chooseOrigin(arguments.origin, *model);
  if (!origin.ok()) return fail(origin.error());
  terrain::moveTo(*origin, *model);
  if (arguments.origin == "auto" && *origin != glm::dvec3(0))
    model->notes.push_back(originNote(*origin, arguments.output));
  const auto original =
      terrain::makeOriginal(*model, arguments.strict ? terrain::OnDefect::kRefuse : terrain::OnDefect::kRepair);
  if (!original.ok()) return fail(original.error());
  const auto poses = apps::readPoses(arguments.poses, arguments.reading, *origin, *model, *original);
  if (!poses.ok()) return fail(poses.error());
  const double finest = arguments.step.value_or(terrain::finestQuantum(original->positions));
  if (Status s = terrain::checkQuantum(original->positions, finest); !s.ok())
    return fail({s.error().code, arguments.input.string() + ": " + s.error().message});
  arguments.remesh.keep_going = [](int) { return !apps::isStopRequested(); };
  const auto remeshed = terrain::remesh(*original, arguments.remesh);
  if (!remeshed.ok()) return fail(remeshed.error());

  const double step = arguments.step.value_or(terrain::defaultQuantum(*remeshed));
  auto surface = terrain::toSurface(*remeshed, arguments.rule, step);
  if (!surface.ok()) return fail(surface.error());
  Finished finished;
  finished.about.title = arguments.input.filename().string();
  finished.about.notes = model->notes;
  const auto repairs = apps::repairNotes(*original);
  finished.about.notes.insert(finished.about.notes.end(), repairs.begin(), repairs.end());
  if (Status s = addColours(arguments, *model, *original, *remeshed, finished); !s.ok()) return fail(s.error());
  apps::RemeshReport report = apps::judgeRemesh(*model, *original, *surface, arguments.remesh.threads);
  report.atlas = finished.painted.atlas;
  finished.about.notes.push_back(apps::sentence(report));
  std::vector<Time> pose_times;
  if (!poses->empty()) {
    auto posed = apps::makePosed(*poses, *original, *remeshed, arguments.rule, step, arguments.remesh.threads);
    if (!posed.ok()) return fail(posed.error());
    surface = std::move(posed->surface);
    report.poses = std::move(posed->reports);
    for (const apps::Pose& pose : *poses) pose_times.push_back(pose.time);
  }
  const auto records = terrain::computeBounds(
      *surface, {.threads = arguments.remesh.threads, .onProgress = [](double) { return !apps::isStopRequested(); }});
  if (apps::isStopRequested()) return fail({ErrorCode::kInvalidArgument, "stopped; nothing was written"});
  const terrain::SolidsFound solids = terrain::findSolids(*surface);
  report.solids = solids.inner;
  report.why_no_solids = solids.why_none;
  report.largest_error = terrain::largestError(surface->topology, records);
  const auto id = terrain::writeSurface(arguments.output, {.surface = *surface,
                                                           .pose_times = pose_times,
                                                           .records = records,
                                                           .atlas = finished.painted.atlas,
                                                           .texels = finished.painted.texels,
                                                           .origin = *origin,
                                                           .inner = solids.inner,
                                                           .about = finished.about});
  if (!id.ok()) return fail(id.error());
  report.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  for (const std::string& note : finished.about.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  report.notes = finished.about.notes;
  apps::printReport(report, arguments.output, *id, arguments.json);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a surface from a polygon model: a base mesh, and the position of each vertex of its refinement.",
               "foreland remesh"};
  Arguments arguments;
  describeShape(app, arguments);
  describeModel(app, arguments);
  describeRun(app, arguments);
  apps::addForeignFiles(app, arguments.foreign);
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"a model", "foreland remesh tower.obj -o tower.fls"},
       {"a model that moves",
        "foreland remesh crane.obj --pose 2004-10-04=crane.obj --pose 2004-10-05=crane-left.obj -o crane.fls"}});
  if (exit_code) return *exit_code;
  arguments.reading.allowed = arguments.foreign.allowed;
  apps::confineTo(arguments.foreign, filesOf(arguments), {arguments.output});
  apps::catchStopSignals();
  return remesh(arguments);
}
