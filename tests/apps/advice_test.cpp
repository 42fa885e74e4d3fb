// What messages advise is done, as a user would, and works. The table has each of them: what makes a program say it,
// and the commands that it advises. A second test finds messages in the sources that the table lacks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/apps/advice_files.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace foreland::test {
namespace {

// Commands are words that blanks separate, '...' with blanks; the first is a program, and `@` at the beginning of a
// word, or behind a `=`, is the folder (FOLDER/ anywhere).
struct Advice {
  std::string literal;              // a part of the message as the source has it
  std::string said;                 // a part of the message as it is said; empty: the literal
  std::vector<std::string> before;  // commands that make files
  std::string command;              // which makes a program say it
  std::vector<std::string> then;    // what is advised: each succeeds, and those of ours do not say it again
};

const std::string kWarp = "/usr/bin/gdalwarp -q ", kTranslate = "/usr/bin/gdal_translate -q ";
// Of a picture along a track, as small as may be.
const std::string kRender =
    "render @degrees.fls --full -o @picture%d.png --viewport 8x8 --every 60 --seconds 1 --track ";

std::vector<Advice> elevation() {
  return {
      {"say --encoding terrarium or terrain-rgb; ",
       "say --encoding terrarium",
       {},
       "build @noise.ppm -o @a.fls",
       {"build @noise.ppm --encoding terrarium -o @a.fls"}},
      {"--imagery lays it over elevation",
       "",
       {},
       "build @noise.ppm -o @a.fls",
       {"build @hills.tif --imagery @noise.ppm -o @a.fls"}},
      {"a picture with a palette, not heights; --imagery",
       "",
       {kTranslate + "@palette.vrt @palette.tif"},
       "build @palette.tif -o @a.fls",
       {"build @hills.tif --imagery @palette.tif -o @a.fls"}},
      {"--channel 1 is the first",
       "",
       {},
       "build @hills.tif --channel 7 -o @a.fls",
       {"build @hills.tif --channel 1 -o @a.fls"}},
      {"--encoding terrarium and terrain-rgb need three bands of 8 bits; leave it out",
       "",
       {},
       "build @hills.tif --encoding terrarium -o @a.fls",
       {"build @hills.tif -o @a.fls"}},
      {"--channel N picks another",
       "",
       {kTranslate + "-b 1 -b 1 @hills.tif @two.tif"},
       "build @two.tif -o @a.fls",
       {"build @two.tif --channel 2 -o @a.fls"}},
      {"which is unknown; taken as metres (--height-unit)",
       "",
       {},
       "build @furlong.vrt -o @a.fls",
       {"build @furlong.vrt --height-unit ft -o @a.fls"}},
      {"its heights are in {}; converted to metres (--height-unit m takes them as they are)",
       "--height-unit m takes them as they are",
       {},
       "build @feet.vrt -o @a.fls",
       {"build @feet.vrt --height-unit m -o @a.fls"}},
      {"by its vertical reference system; converted to metres (--height-unit m takes them as they are)",
       "",
       {},
       "build @vertical.vrt -o @a.fls",
       {"build @vertical.vrt --height-unit m -o @a.fls"}},
      {"--height-unit ft or us-ft",
       "",
       {},
       "build @map_in_feet.vrt -o @a.fls",
       {"build @map_in_feet.vrt --height-unit ft -o @a.fls", "build @map_in_feet.vrt --height-unit us-ft -o @a.fls"}},
      {"(--encoding {0}; a picture: --imagery)",
       "(--encoding terrarium; a picture: --imagery)",
       {},
       "build @terrarium.ppm -o @a.fls",
       {"build @terrarium.ppm --encoding terrarium -o @a.fls", "build @hills.tif --imagery @terrarium.ppm -o @a.fls"}},
      {"a globe's first input must go around it in latitude and longitude; what covers a part comes as --inset",
       "",
       {},
       "build @hills.tif --globe -o @a.fls",
       {"build @planet.vrt --globe --inset @hills.tif -o @a.fls"}},
      {"nothing says what the heights are above, so they are taken as above the ellipsoid",
       "",
       {},
       "build @planet.vrt --globe -o @a.fls",
       {"build @planet.vrt --globe --vertical egm96 -o @a.fls"}},
      {"another with --nodata", "", {}, "build @void.asc -o @a.fls", {"build @void.asc --nodata -1 -o @a.fls"}},
      {"--nodata names another value",
       "",
       {},
       "build @untagged.vrt -o @a.fls",
       {"build @untagged.vrt --nodata -9999 -o @a.fls"}},
      {"holds several variables; choose one with --channel: {}",
       "choose one with --channel: ",
       {kTranslate + "-b 1 -b 1 @hills.tif @two.tif", kTranslate + "-of netCDF @two.tif @two.nc"},
       "build @two.nc -o @a.fls",
       {"build @two.nc --channel Band2 -o @a.fls"}},
      {"{}: {}; choose one with --channel: {}",
       "choose one with --channel: height",
       {"synth -o @land.exr --size 65"},
       "build @land.exr --channel Q -o @a.fls",
       {"build @land.exr --channel height -o @a.fls"}},
      {"; convert it first with gdal_translate -ot Float32 -scale 0 1 0 0.3048",
       "",
       {kTranslate + "-ot Float64 -scale 0 1000 0 3280.84 @hills.tif @in_feet.tif"},
       "build @hills.tif @in_feet.tif -o @a.fls",
       {kTranslate + "-ot Float32 -scale 0 1 0 0.3048 @in_feet.tif @metres.tif",
        "build @hills.tif @metres.tif -o @a.fls"}},
      {": --vertical file: its reference system does not say what its heights are above; say ",
       "say ellipsoid, egm96, egm2008 or a grid's file",
       {},
       "build @hills.tif --vertical file -o @a.fls",
       {"build @hills.tif --vertical ellipsoid -o @a.fls", "build @hills.tif --vertical egm96 -o @a.fls"}},
      {": --vertical ",
       "nowhere.gtx: neither ellipsoid, egm96 nor egm2008",
       {},
       "build @hills.tif --vertical @nowhere.gtx -o @a.fls",
       {"build @hills.tif --vertical egm96 -o @a.fls"}},
      {"--scene-vertical ",
       "nowhere.gtx: neither ellipsoid, egm96 nor egm2008",
       {},
       "build @hills.tif --vertical ellipsoid --scene-vertical @nowhere.gtx -o @a.fls",
       {"build @hills.tif --vertical ellipsoid --scene-vertical egm96 -o @a.fls"}},
      {"so no geoid is known over it; name one with gdal_translate -a_srs",
       "",
       {},
       "build @hills.asc --vertical egm96 --scene-vertical ellipsoid -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 @hills.asc @named.tif",
        "build @named.tif --vertical egm96 --scene-vertical ellipsoid -o @a.fls"}},
      {"--spacing is for files without a reference system",
       "",
       {},
       "build @hills.tif --spacing 30 -o @a.fls",
       {"build @hills.tif -o @a.fls"}},
      {"--frame geographic needs coordinates in degrees, and this file has none",
       "",
       {},
       "build @noise.ppm --encoding terrarium --frame geographic -o @a.fls",
       {"build @noise.ppm --encoding terrarium -o @a.fls"}},
      {"--spacing M sets it",
       "",
       {},
       "build @terrarium.ppm -o @a.fls",
       {"build @terrarium.ppm --spacing 30 -o @a.fls"}},
      {"--frame planar takes them as metres",
       "",
       {},
       "build @degrees.asc -o @a.fls",
       {"build @degrees.asc --frame planar -o @a.fls"}},
      {"--frame planar would flatten {:.1f} x {:.1f} degrees, too much of the globe; leave it out",
       "too much of the globe; leave it out",
       {kTranslate + "-a_srs EPSG:4326 -a_ullr 0 40 40 0 @hills.tif @wide.tif"},
       "build @wide.tif --frame planar -o @a.fls",
       {"build @wide.tif -o @a.fls"}},
      {"--frame geographic cannot be meant for map coordinates (",
       "gdalwarp -t_srs EPSG:4326 -dstnodata -9999, or leave --frame out",
       {},
       "build @hills.tif --frame geographic -o @a.fls",
       {kWarp + "-t_srs EPSG:4326 -dstnodata -9999 @hills.tif @warped.tif",
        "build @warped.tif --frame geographic -o @a.fls", "build @hills.tif -o @a.fls"}},
      {"); convert the file first with gdalwarp -t_srs EPSG:4326 -dstnodata -9999, or leave --frame out",
       "",
       {},
       "build @hills.tif --frame geographic -o @a.fls",
       {"build @hills.tif -o @a.fls"}},
      {"straighten it first with gdalwarp -t_srs EPSG:4326 -dstnodata -9999",
       "",
       {},
       "build @turned.vrt -o @a.fls",
       {kWarp + "-t_srs EPSG:4326 -dstnodata -9999 @turned.vrt @straight.tif", "build @straight.tif -o @a.fls"}},
      {"position with gdal_translate -a_ullr",
       "",
       {kTranslate + "-a_srs EPSG:4326 -a_ullr 8 95 9 85 @hills.tif @pole.tif"},
       "build @pole.tif -o @a.fls",
       {kTranslate + "-a_ullr 8 47 9 46 @pole.tif @moved.tif", "build @moved.tif -o @a.fls"}},
      {"$(gdalsrsinfo --single-line -o wkt {})",
       "gdal_translate -a_srs \"$(gdalsrsinfo --single-line -o wkt ",
       {kTranslate + "-a_srs '+proj=tmerc +lon_0=9 +k=0.9996 +x_0=500001' @hills.asc @own.tif"},
       "build @own.tif @hills.asc -o @a.fls",
       {"/bin/sh -c 'gdal_translate -q -a_srs \"$(gdalsrsinfo --single-line -o wkt FOLDER/own.tif)\" FOLDER/hills.asc "
        "FOLDER/there.tif'",
        "build @own.tif @there.tif -o @a.fls"}},
      {"if it is that of both, say so with gdal_translate -a_srs ",
       "gdal_translate -a_srs EPSG:32632",
       {},
       "build @hills.tif @hills.asc -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 @hills.asc @named.tif", "build @hills.tif @named.tif -o @a.fls"}},
      {" is unknown; give it one with gdal_translate -a_srs -a_ullr",
       "",
       {},
       "build @hills.tif --inset @terrarium.ppm -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 -a_ullr 400100 5149000 400600 5148500 @terrarium.ppm @placed.tif",
        "build @hills.tif --inset @placed.tif -o @a.fls"}},
      {"takes no inputs of other grids; leave --frame planar out",
       "",
       {kTranslate + "-a_srs EPSG:4326 @degrees.asc @deg.tif"},
       "build @deg.tif --frame planar --inset @deg.tif -o @a.fls",
       {"build @deg.tif --inset @deg.tif -o @a.fls"}},
      {"so where they lie to each other is unknown; name it with gdal_translate -a_srs",
       "",
       {},
       "build @hills.tif --inset @hills.asc -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 @hills.asc @named.tif", "build @hills.tif --inset @named.tif -o @a.fls"}},
      {"if one of them is wrong, correct it with gdal_translate -a_srs",
       "",
       {kTranslate + "-a_srs '+proj=utm +zone=32 +a=3396190 +b=3376200 +units=m' @hills.asc @mars.tif"},
       "build @hills.tif --inset @mars.tif -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 @mars.tif @earth.tif", "build @hills.tif --inset @earth.tif -o @a.fls"}},
      {"name it as another input and not as an --inset",
       "",
       {kTranslate + "-a_srs EPSG:32632 -a_ullr 405000 5149000 406000 5148000 @hills.asc @away.tif"},
       "build @hills.tif --inset @away.tif -o @a.fls",
       {"build @hills.tif @away.tif -o @a.fls"}},
      {"or allow a larger --residual",
       "",
       {kTranslate + "-a_srs EPSG:32632 -a_ullr 400300 5148600 400300.01 5148599.99 @hills.asc @needle.tif"},
       "build @hills.tif --inset @needle.tif -o @a.fls",
       {"build @hills.tif --inset @needle.tif --residual 1000 -o @a.fls"}},
      {"convert it first, e.g. gdalwarp -t_srs EPSG:4326 -dstnodata -9999",
       "",
       {},
       "build @rotated_pole.vrt -o @a.fls",
       {kWarp + "-t_srs EPSG:4326 -dstnodata -9999 @rotated_pole.vrt @from_pole.tif",
        "build @from_pole.tif -o @a.fls"}},
      {"--frame projected keeps the map",
       "",
       {kWarp + "-t_srs EPSG:3857 @hills.tif @mercator.tif"},
       "build @mercator.tif -o @a.fls",
       {"build @mercator.tif --frame projected -o @a.fls"}},
      {"see unzip -l",
       "",
       {"/usr/bin/env python3 -m zipfile -c @notes.zip @notes.txt"},
       "build @notes.zip -o @a.fls",
       {"/usr/bin/unzip -l @notes.zip"}},
      {"if you trust it, say --allow-files-from ",
       "",
       {},
       "build @below/outside.vrt -o @a.fls",
       {"build @below/outside.vrt --allow-files-from @. -o @a.fls"}},
  };
}

std::vector<Advice> pictures() {
  const std::string over = "build @hills.tif -o @a.fls --imagery ";
  return {
      {"leave --frame planar out",
       "",
       {kTranslate + "-a_srs EPSG:4326 @degrees.asc @degrees.tif"},
       "build @degrees.tif --frame planar --imagery @noise.ppm -o @a.fls",
       {"build @degrees.tif --imagery @noise.ppm -o @a.fls"}},
      {"Choose three with gdal_translate -b RED -b GREEN -b BLUE",
       "",
       {kTranslate + "-b 1 -b 2 -b 3 -b 1 -b 2 @noise.ppm @five.tif"},
       over + "@five.tif",
       {kTranslate + "-b 3 -b 2 -b 1 @five.tif @three.tif", over + "@three.tif"}},
      {"convert them with gdal_translate -ot Byte -scale",
       "",
       {},
       over + "@hills.tif",
       {kTranslate + "-ot Byte -scale @hills.tif @bytes.tif", over + "@bytes.tif"}},
      {"--imagery-alpha use takes it as alpha",
       "",
       {kTranslate + "-b 1 -b 2 -b 3 -b 1 -colorinterp_4 alpha @noise.ppm @nir.tif"},
       over + "@nir.tif",
       {over + "@nir.tif --imagery-alpha use", over + "@nir.tif --imagery-alpha ignore"}},
      {"elevation one with gdal_translate -a_srs",
       "",
       {kTranslate + "-a_srs EPSG:32632 -a_ullr 400000 5149950 401950 5148000 @noise.ppm @placed.tif"},
       "build @hills.asc --imagery @placed.tif -o @a.fls",
       {kTranslate + "-a_srs EPSG:32632 @hills.asc @named.tif", "build @named.tif --imagery @placed.tif -o @a.fls"}},
  };
}

std::vector<Advice> models() {
  const std::string how = " --base-triangles 4 --levels 1 -o @a.model.fls";
  return {
      {"move the model (--origin) or choose a coarser step (--step)",
       "",
       {},
       "remesh @far.obj --origin file --step 1e-6" + how,
       {"remesh @far.obj --origin 400000,5148500,0 --step 1e-6" + how,
        "remesh @far.obj --origin file --step 0.01" + how}},
      {"pack it with EXT_meshopt_compression (gltfpack -c), or not at all",
       "",
       {},
       "remesh @packed.gltf" + how,
       {"remesh @unpacked.gltf" + how}},
      {"if you trust it, say --allow-files-from ",
       "",
       {},
       "remesh @below/tower.obj" + how,
       {"remesh @below/tower.obj --allow-files-from @." + how}},
      {"put it beside the model",
       "",
       {},
       "remesh @below/without.obj" + how,
       {"/bin/cp @tower.mtl @below/lost.mtl", "remesh @below/without.obj" + how}},
      {"put the file beside the model",
       "",
       {},
       "remesh @below/drive.obj" + how,
       {"/bin/cp @tower.mtl @below/drive.mtl", "remesh @below/drive.obj" + how}},
  };
}

std::vector<Advice> tracks() {
  return {
      {"no times recorded; 10 m/s along the track assumed (--speed changes it)",
       "",
       {},
       kRender + "@bare.gpx",
       {kRender + "@bare.gpx --speed 2"}},
      {"fixes; flown at 10 m/s there (--speed changes it)",
       "flown at 10 m/s there (--speed changes it)",
       {},
       kRender + "@still.gpx",
       {kRender + "@still.gpx --speed 2"}},
      {"flown at a constant speed there (--speed changes it)",
       "",
       {},
       kRender + "@partly.gpx",
       {kRender + "@partly.gpx --speed 2"}},
      {"--agl M flies above the ground", "", {}, kRender + "@above.kml --agl 50", {kRender + "@above.kml --agl 100"}},
      {"give a height above ground with --agl", "", {}, kRender + "@above.kml", {kRender + "@above.kml --agl 50"}},
      {" is after the track's end; it lasts ",
       "",
       {},
       kRender + "@bare.gpx --from 100000",
       {kRender + "@bare.gpx --from 1"}},
      {"(gdalwarp -t_srs EPSG:4326 -dstnodata -9999 makes it so), or fly a tour (--tour)",
       "",
       {"build @hills.tif -o @planar.fls"},
       "render @planar.fls --full --viewport 8x8 --every 60 --seconds 1 -o @picture%d.png --track @bare.gpx",
       {kWarp + "-t_srs EPSG:4326 -dstnodata -9999 @hills.tif @warped.tif", "build @warped.tif -o @warped.fls",
        "render @warped.fls --full --viewport 8x8 --every 60 --seconds 1 -o @picture%d.png --track @hills.gpx",
        "render @planar.fls --full --viewport 8x8 --every 60 --seconds 1 -o @picture%d.png --tour survey"}},
      {"raise --speed or state --seconds",
       "",
       {},
       "render @degrees.fls --full -o @picture%d.png --viewport 8x8 --every 86400 --track @long.gpx",
       {"render @degrees.fls --full -o @picture%d.png --viewport 8x8 --every 86400 --speed 10000 --track @long.gpx",
        "render @degrees.fls --full -o @picture%d.png --viewport 8x8 --every 86400 --seconds 1 --track @long.gpx"}},
      {"unpack it and name the .kml file in it",
       "",
       {"/usr/bin/env python3 -m zipfile -c @above.kmz @above.kml"},
       kRender + "@above.kmz --agl 50",
       {"/usr/bin/unzip -o -q @above.kmz -d @unpacked", kRender + "@unpacked/above.kml --agl 50"}},
  };
}

std::vector<Advice> allAdvice() {
  std::vector<Advice> all;
  for (const auto& some : {elevation(), pictures(), models(), tracks()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

// Ranges of options, options that are to be left out, and what cannot be made to happen here.
constexpr std::array kNotRun{
    "--speed must be above 0", "--from must not be negative", "--seconds must be positive", "--clearance must be 0 to",
    "--agl must be 0 to", "--from ", "is no distance in metres", "gives three numbers",
    "texels are too many; take a smaller --imagery-detail",  // of a picture of terabytes
    "try gdalwarp -tps -dstnodata -9999 {} placed.tif",      // GDAL places whatever control points it can read
    "its reference system cannot be related to the elevation's; convert it first with gdalwarp -t_srs",  // PROJ relates
                                                                                                         // all
    "more than 2^24 a side; cut out", "more than 2^32; make it coarser",                   // of rasters of terabytes
    "PROJ knows no exact transformation between their reference systems on this machine",  // which depends on that
    "so places may be off by up to 200 m; `projsync --file` or the package proj-data brings the grids",
    "holds no data, only voids; check the file and --nodata",  // reading a file of voids says so before
    "no grid of undulations: it has",                          // tests/terrain/dem/vertical has such a grid
    "its georeference is degenerate; correct it with gdal_translate -a_ullr",  // GDAL drops such a georeference
    "its reference system has no unit; name one with gdal_translate -a_srs",   // GDAL gives it a unit
    // Pictures on globes: GDAL relates all reference systems, and drops a georeference that is none.
    "brought to latitude and longitude; convert it first with gdalwarp -t_srs ",
    "it names no reference system; give it one with gdal_translate -a_srs",
    "it has no position; give it one with gdal_translate -a_ullr",
    "it does not lie between the poles, north up; correct it with gdalwarp -t_srs EPSG:4326",
    "with gdal_translate -outsize",  // a picture of 2^28 pixels
};

class AdviceOf : public testing::TestWithParam<Advice> {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "below");
    makeElevation(folder_.path());
    makePictures(folder_.path());
    makeModels(folder_.path());
    makeTracks(folder_.path());
    run(kTranslate + "-a_srs EPSG:32632 @hills.asc @hills.tif");
    const std::string files = GetParam().command + GetParam().said;
    if (files.find("@degrees.fls") != std::string::npos) run("build @degrees.asc --frame geographic -o @degrees.fls");
  }
  std::vector<std::string> wordsOf(const std::string& command) const {
    std::vector<std::string> words;
    static const std::regex kWord("'([^']*)'|[^ ']+");
    for (std::sregex_iterator word(command.begin(), command.end(), kWord), end; word != end; ++word) {
      std::string text = (*word)[1].matched ? (*word)[1].str() : word->str();
      for (size_t at; (at = text.find("FOLDER/")) != text.npos;) text.replace(at, 7, folder_.path().string() + "/");
      const size_t at = text.starts_with('@')                  ? 0
                        : text.find("=@") == std::string::npos ? text.npos
                                                               : text.find("=@") + 1;
      if (at != std::string::npos) text.replace(at, 1, folder_.path().string() + "/");
      words.push_back(std::move(text));
    }
    return words;
  }
  ProgramResult result(const std::string& command) const {
    std::vector<std::string> words = wordsOf(command);
    const std::string name = words.front();
    words.erase(words.begin());
    return runProgram(name, words);
  }
  std::string run(const std::string& command) const {
    const ProgramResult ended = result(command);
    EXPECT_EQ(ended.exit_code, 0) << command << ": " << ended.output;
    return ended.output;
  }

  TemporaryFolder folder_;
};

TEST_P(AdviceOf, AMessageIsRunAndWorks) {
  const Advice& advice = GetParam();
  const std::string said = advice.said.empty() ? advice.literal : advice.said;
  for (const std::string& command : advice.before) run(command);
  const ProgramResult first = result(advice.command);
  EXPECT_NE(first.output.find(said), std::string::npos) << advice.command << " says: " << first.output;
  // Where the option changes what is assumed, the assumption is still said.
  const bool is_assumption = said.find("--speed changes it") != std::string::npos ||
                             said.find("--agl M") != std::string::npos || said.starts_with("--nodata names");
  for (const std::string& command : advice.then) {
    const std::string output = run(command);
    if (command.starts_with('/') || is_assumption) continue;
    EXPECT_EQ(output.find(said), std::string::npos) << command << " says it again: " << output;
  }
}
INSTANTIATE_TEST_SUITE_P(All, AdviceOf, testing::ValuesIn(allAdvice()),
                         [](const auto& row) { return std::to_string(row.index); });

// String literals of a source, those joined that follow each other.
std::vector<std::string> literalsOf(const std::string& source) {
  static const std::regex kComment("//[^\n]*"), kLiteral("\"((?:[^\"\\\\\n]|\\\\.)*)\"");
  const std::string text = std::regex_replace(source, kComment, "");
  std::vector<std::string> literals;
  size_t last_end = std::string::npos;
  for (std::sregex_iterator at(text.begin(), text.end(), kLiteral), end; at != end; ++at) {
    const auto begin = static_cast<size_t>(at->position());
    const bool follows = last_end != std::string::npos && text.find_first_not_of(" \n", last_end) == begin;
    if (follows)
      literals.back() += (*at)[1].str();
    else
      literals.push_back((*at)[1].str());
    last_end = begin + static_cast<size_t>(at->length());
  }
  return literals;
}

TEST(AdviceTable, HasWhateverMessagesAdvise) {
  static const std::regex kAdvice("--[a-z]{3}|gdalwarp|gdal_translate|gdalsrsinfo|unzip|gltfpack|unpack it and");
  const std::vector<Advice> all = allAdvice();
  size_t count = 0;
  for (const char* folder :
       {"terrain/dem", "terrain/fence", "terrain/imagery", "terrain/model", "terrain/remesh", "client/fly"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(FORELAND_SOURCE_DIR) / folder)) {
      const fs::path& file = entry.path();
      if (file.extension() != ".cpp" && file.extension() != ".h") continue;
      const std::string room = file.parent_path().filename();
      if ((room == "fly" && file.filename() != "track_path.cpp") || room == "net") continue;  // no foreign files
      const std::vector<char> bytes = slurp(file);
      for (const std::string& literal : literalsOf({bytes.begin(), bytes.end()})) {
        if (!std::regex_search(literal, kAdvice)) continue;
        ++count;
        const auto isIn = [&](const std::string& part) { return literal.find(part) != std::string::npos; };
        EXPECT_TRUE(std::ranges::any_of(all, isIn, &Advice::literal) || std::ranges::any_of(kNotRun, isIn))
            << file << " advises what no test runs: " << literal;
      }
    }
  EXPECT_GT(count, 30u);
}

}  // namespace
}  // namespace foreland::test
