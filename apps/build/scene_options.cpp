#include "apps/build/scene_options.h"

#include <map>
#include <utility>

#include "apps/options/options.h"
#include "apps/options/output_file.h"

namespace foreland::apps {

namespace {

void describePages(CLI::App& app, SceneArguments& arguments) {
  static const std::map<std::string, terrain::PageCoding> codings{{"plain", terrain::PageCoding::kPlain},
                                                                  {"coded", terrain::PageCoding::kCoded}};
  app.add_option_function<std::string>(
         "--pages", [&](const std::string& name) { arguments.page_coding = codings.at(name); },
         "how the ground stands in the file: plain, eight bytes a sample, which are used where they lie; coded: about "
         "a tenth, inflated when they are first touched (serve --page-cache-mib), for scenes larger than memory "
         "and disk. What viewers get is the same")
      ->check(oneOf({"plain", "coded"}))
      ->default_str("plain");
}

void describeObjects(CLI::App& app, SceneArguments& arguments) {
  app.add_option(
         "--object", arguments.objects,
         "a surface made by `foreland remesh` that stands on the terrain; LAT and LON in degrees, in planar "
         "scenes x and y of the map in metres; here: where the model's own coordinates are on the "
         "map of the scene, and at their height. The dates of its poses are the scene's epochs, unless there is "
         "--epoch: then each is one of these")
      ->type_name(text("MODEL.fls@LAT,LON|here[,HEIGHT[,HEADING[,SCALE]]]"))
      ->allow_extra_args(false);
}

void describeImagery(CLI::App& app, SceneArguments& arguments) {
  CLI::Option* imagery = app.add_option(
      "--imagery", arguments.imagery,
      "pictures to lay over the terrain: whatever GDAL reads, grey, palette, RGB or RGBA of 8 bits, in any reference "
      "system; where they overlap, the finest shows. One without georeference is laid over the whole scene");
  imagery->type_name(file("FILE"));
  app.add_option("--imagery-quality", arguments.imagery_quality, "of the pictures' WebP")
      ->type_name(whole("Q"))
      ->check(within(1, 100))
      ->needs(imagery)
      ->capture_default_str();
  static const std::map<std::string, terrain::AlphaChoice> alphas{{"auto", terrain::AlphaChoice::kAuto},
                                                                  {"use", terrain::AlphaChoice::kUse},
                                                                  {"ignore", terrain::AlphaChoice::kIgnore}};
  app.add_option_function<std::string>(
         "--imagery-alpha", [&](const std::string& name) { arguments.imagery_alpha = alphas.at(name); },
         "what to make of a last band of the pictures that is tagged as alpha; by default it is left out, with a note, "
         "where it is hardly anywhere opaque, as infrared is not")
      ->check(oneOf({"auto", "use", "ignore"}))
      ->needs(imagery)
      ->default_str("auto");
  app.add_option("--attribution", arguments.attribution, "whom viewers name where they show the pictures")
      ->type_name(text("NAME"))
      ->needs(imagery);
}

}  // namespace

void describeAdditions(CLI::App& app, SceneArguments& arguments) {
  describePages(app, arguments);
  describeImagery(app, arguments);
  describeObjects(app, arguments);
}

std::vector<std::filesystem::path> filesOf(const SceneArguments& arguments) {
  std::vector<std::filesystem::path> files = arguments.imagery;
  for (const std::string& text : arguments.objects) files.emplace_back(text.substr(0, text.rfind('@')));
  return files;
}

Status checkApart(const std::filesystem::path& output, const SceneArguments& arguments) {
  for (const std::filesystem::path& picture : arguments.imagery)
    if (Status s = checkApart(output, picture, "one of the pictures"); !s.ok()) return s;
  return {};
}

Result<std::vector<terrain::ObjectRequest>> parseObjects(const SceneArguments& arguments) {
  std::vector<terrain::ObjectRequest> objects;
  for (const std::string& text : arguments.objects) {
    auto object = terrain::parseObject(text);
    if (!object.ok()) return object.error();
    objects.push_back(std::move(*object));
  }
  return objects;
}

Result<OpenedAdditions> openAdditions(const SceneArguments& arguments, const terrain::ElevationInfo& ground,
                                      const std::vector<std::filesystem::path>& allowed_folders) {
  auto objects = parseObjects(arguments);
  if (!objects) return objects.error();
  OpenedAdditions opened;
  if (!arguments.imagery.empty()) {
    auto picture = terrain::openPictures(arguments.imagery, {ground.frame, ground.crs_wkt, ground.width, ground.height,
                                                             allowed_folders, arguments.imagery_alpha});
    if (!picture) return picture.error();
    opened.picture = std::move(*picture);
  }
  opened.additions = {.page_coding = arguments.page_coding,
                      .objects = std::move(*objects),
                      .picture = opened.picture.get(),
                      .imagery_quality = arguments.imagery_quality,
                      .attribution = arguments.attribution};
  return opened;
}

}  // namespace foreland::apps
