// `foreland heights`: heights of a scene at the places that standard input names, one a line, as CSV on standard
// output. Exit codes: 0 every line was answered, 2 otherwise. One thread; a line is answered before the next is waited
// for.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "apps/heights/scene_heights.h"
#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/options.h"
#include "apps/options/place.h"
#include "terrain/store/file/mapped_file.h"

namespace foreland::apps {

namespace {

constexpr const char* kFooter = R"(
Places are longitude,latitude in degrees, in planar scenes x,y of the map in metres; what follows on a line is not looked at, nor are
empty lines, lines that begin with #, and a first line that begins with a letter. Heights are bilinear between the scene's samples.
above_sea_m and above_ellipsoid_m are empty where the scene does not state its vertical datum or knows no geoid (`foreland build
--vertical`). All columns but the place are empty beyond the data. source is the input that the height comes from; of scenes that do
not state their datum the names of all inputs. residual_m is by how much the scene differs from it at its samples at most.

Exit code: 0 every line was answered, 2 otherwise. What is wrong with a line is said on standard error, with its number.)";

struct Options {
  std::string scene;
  std::optional<std::string> date;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland heights: %s\n", error.message.c_str());
  return 2;
}

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// Takes a number and the comma behind it, if there is one, off the text.
std::optional<double> takeNumber(std::string_view& text) {
  const size_t comma = text.find(',');
  std::string_view word = trimmed(text.substr(0, comma));
  text = comma == std::string_view::npos ? "" : text.substr(comma + 1);
  if (word.starts_with('+')) word.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

// As CSV has it (RFC 4180).
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4f", value);
  return text;
}

class Answers {
 public:
  Answers(const terrain::Scene& scene, Time scene_time)
      : scene_(scene),
        transform_(scene.frame()),
        scene_time_(scene_time),
        is_planar_(scene.frame().kind == proto::FrameKind::kPlanar) {
    std::printf("%s,height_m,above_sea_m,above_ellipsoid_m,source,residual_m\n",
                is_planar_ ? "x,y" : "longitude,latitude");
  }

  // False, with a message, if it is no place.
  bool answer(uint64_t number, std::string_view line) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') return true;
    if (number == 1 && std::isalpha(static_cast<unsigned char>(line.front())) != 0) return true;
    const auto x = takeNumber(line), y = takeNumber(line);
    if (!x || !y) return refuse(number, is_planar_ ? "write x,y" : "write longitude,latitude");
    if (!is_planar_ && (std::fabs(*y) > 90 || std::fabs(*x) > 720))
      return refuse(number,
                    "the scene is geographic: longitude and latitude are in degrees, and longitude comes first");
    print(*x, *y);
    return true;
  }

 private:
  static bool refuse(uint64_t number, const char* why) {
    std::fprintf(stderr, "foreland heights: line %llu: %s\n", static_cast<unsigned long long>(number), why);
    return false;
  }

  void print(double x, double y) const {
    std::printf(is_planar_ ? "%.4f,%.4f," : "%.9f,%.9f,", x, y);
    const proto::LatticePosition lattice = is_planar_ ? latticeOf(transform_, x, y) : latticeOf(transform_, y, x);
    const auto at = heightAt(scene_, {lattice.x, lattice.y}, scene_time_);
    if (!at) {
      std::printf(",,,,\n");
      return;
    }
    const std::string sea = seaOf(*at), ellipsoid = ellipsoidOf(*at);
    std::printf("%s,%s,%s,%s,", metres(at->height_m).c_str(), sea.c_str(), ellipsoid.c_str(),
                field(at->source).c_str());
    if (at->residual_m) std::printf("%g", *at->residual_m);
    std::printf("\n");
  }

  // What is stated is known without a geoid, too.
  std::string seaOf(const SceneHeight& at) const {
    if (at.both) return metres(at.both->above_sea_m);
    return scene_.vertical().zero_surface == proto::ZeroSurface::kGeoid ? metres(at.height_m) : "";
  }
  std::string ellipsoidOf(const SceneHeight& at) const {
    if (at.both) return metres(at.both->above_ellipsoid_m);
    return scene_.vertical().zero_surface == proto::ZeroSurface::kEllipsoid ? metres(at.height_m) : "";
  }

  const terrain::Scene& scene_;
  const proto::FrameTransform transform_;
  Time scene_time_;
  bool is_planar_;
};

int heights(const Options& o) {
  const auto scene = terrain::Scene::open(o.scene);
  if (!scene.ok()) return fail(scene.error());
  const proto::Epochs& epochs = (*scene)->epochs().epochs();
  Time scene_time = epochs.empty() ? Time{} : epochs.last();
  if (o.date) {
    const auto date = parseDateOption(*o.date, o.scene, epochs);
    if (!date.ok()) return fail(date.error());
    scene_time = *date;
  }
  Answers answers(**scene, scene_time);
  bool all_answered = true;
  std::string line;
  std::ios::sync_with_stdio(false);
  for (uint64_t number = 1; std::getline(std::cin, line); ++number) {
    all_answered = answers.answer(number, line) && all_answered;
    if (std::cin.rdbuf()->in_avail() <= 0) std::fflush(stdout);  // who asks may wait for this answer
  }
  if (std::fflush(stdout) != 0) return fail({ErrorCode::kIo, "standard output cannot be written"});
  return all_answered ? 0 : 2;
}

const std::vector<Example> kExamples{
    {"a point's height above the sea and above the ellipsoid", "echo 8.5,46.5 | foreland heights alps.fls"},
    {"of many points", "foreland heights alps.fls <points.csv >heights.csv"}};

}  // namespace

}  // namespace foreland::apps

int main(int argc, char** argv) {
  using namespace foreland::apps;
  Options o;
  CLI::App app("Tells heights of a scene at places, as CSV.", "foreland heights");
  app.footer(kFooter);
  app.add_option("SCENE", o.scene, "the scene file")->type_name(file("SCENE.fls"))->required();
  app.add_option("--date", o.date, "in scenes that change in time: of which date the ground is; by default the last")
      ->type_name(text("YYYY-MM-DD"));
  if (const auto exit_code = parseCommandLine(app, argc, argv, kExamples)) return *exit_code;
  foreland::terrain::endWhenAFileIsLost();
  return heights(o);
}
