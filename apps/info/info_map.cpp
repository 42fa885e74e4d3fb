#include "apps/info/info_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "apps/options/date.h"
#include "apps/options/output_file.h"
#include "terrain/model/png.h"
#include "terrain/render/shading.h"
#include "terrain/store/bilinear.h"
#include "terrain/store/file/new_file.h"

namespace foreland::apps {

namespace {

constexpr double kLongerSide = 1024;
// Apart for most eyes, on ground and on snow.
constexpr std::array<std::array<uint8_t, 3>, 8> kColours{{{230, 25, 75},
                                                          {0, 130, 200},
                                                          {245, 130, 48},
                                                          {145, 30, 180},
                                                          {255, 225, 25},
                                                          {70, 240, 240},
                                                          {240, 50, 230},
                                                          {0, 0, 0}}};

// Metres between samples along x and along y, in the middle of the scene.
glm::dvec2 spacingOf(const terrain::Scene& scene) {
  const proto::Frame& f = scene.frame();
  if (f.kind == proto::FrameKind::kPlanar) return {glm::length(f.axis_x_m), glm::length(f.axis_y_m)};
  const double latitude = f.latitude0_rad + 0.5 * scene.grid().shape().samples_y * f.latitude_step_rad;
  return {f.semi_major_m * f.longitude_step_rad * std::max(std::cos(latitude), 0.1),
          f.semi_major_m * f.latitude_step_rad};
}

std::string resolutionOf(const proto::LatticeWindow& w, glm::dvec2 spacing_m) {
  char text[96];
  std::snprintf(text, sizeof text, "%u x %u samples, %.3g x %.3g m apart", w.width, w.height, spacing_m.x, spacing_m.y);
  return text;
}

struct MapScale {
  uint32_t width, height;
  glm::dvec2 samples_a_pixel;  // along x and along y
};

MapScale scaleOf(const terrain::Scene& scene) {
  const proto::GridShape& s = scene.grid().shape();
  const glm::dvec2 spacing_m = spacingOf(scene), samples(s.samples_x - 1.0, s.samples_y - 1.0);
  const glm::dvec2 extent_m = samples * spacing_m;
  const double most = std::min(kLongerSide, std::max(samples.x, samples.y) + 1);
  const double pixel_m = std::max(extent_m.x, extent_m.y) / most;
  const auto pixels = [&](double metres) { return static_cast<uint32_t>(std::max(1.0, std::round(metres / pixel_m))); };
  const MapScale scale{pixels(extent_m.x), pixels(extent_m.y), {}};
  return {scale.width, scale.height, samples / glm::dvec2(scale.width, scale.height)};
}

class Ground {
 public:
  explicit Ground(const terrain::Scene& scene) : scene_(scene), shape_(scene.grid().shape()) {}

  double heightAt(glm::dvec2 lattice) const {
    const double x = std::clamp(lattice.x, 0.0, shape_.samples_x - 1.0),
                 y = std::clamp(lattice.y, 0.0, shape_.samples_y - 1.0);
    const auto at = [&](uint32_t column, uint32_t row) { return scene_.height(proto::NodeId::at(column, row)); };
    return terrain::bilinear(shape_.samples_x, shape_.samples_y, x, y, at) * scene_.frame().height_quantum_m;
  }

 private:
  const terrain::Scene& scene_;
  proto::GridShape shape_;
};

terrain::Colour colourOf(const glm::vec3& linear) {
  const glm::vec3 shown = terrain::toScreen(linear);
  const auto byte = [](float v) { return static_cast<uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
  return {byte(shown.x), byte(shown.y), byte(shown.z), 255};
}

void drawGround(const terrain::Scene& scene, const terrain::Shading& shading, const MapScale& scale,
                terrain::Image& image) {
  const Ground ground(scene);
  const glm::dvec2 step = scale.samples_a_pixel, run_m = step * spacingOf(scene);
  for (uint32_t row = 0; row < scale.height; ++row)
    for (uint32_t column = 0; column < scale.width; ++column) {
      const glm::dvec2 at(step.x * (column + 0.5), step.y * (scale.height - 1 - row + 0.5));
      const double half_x = 0.5 * step.x, half_y = 0.5 * step.y;
      const double eastward = ground.heightAt({at.x + half_x, at.y}) - ground.heightAt({at.x - half_x, at.y});
      const double northward = ground.heightAt({at.x, at.y + half_y}) - ground.heightAt({at.x, at.y - half_y});
      const glm::dvec3 normal = glm::normalize(glm::dvec3(-eastward / run_m.x, -northward / run_m.y, 1));
      image.pixels.push_back(colourOf(shading.fromAbove(glm::vec3(normal), ground.heightAt(at))));
    }
}

// Two pixels wide, inside of the picture.
void drawOutline(const Outline& outline, const MapScale& scale, terrain::Image& image) {
  const auto pixel = [](double at, uint32_t size) {
    return static_cast<uint32_t>(std::clamp(std::floor(at), 0.0, size - 1.0));
  };
  const proto::LatticeWindow& w = outline.window;
  const uint32_t left = pixel(w.x / scale.samples_a_pixel.x, image.width),
                 right = pixel((w.x + w.width - 1) / scale.samples_a_pixel.x - 1e-9, image.width),
                 bottom = image.height - 1 - pixel(w.y / scale.samples_a_pixel.y, image.height),
                 top = image.height - 1 - pixel((w.y + w.height - 1) / scale.samples_a_pixel.y - 1e-9, image.height);
  const auto& [red, green, blue] = outline.colour;
  for (uint32_t y = top; y <= bottom; ++y)
    for (uint32_t x = left; x <= right; ++x)
      if (x < left + 2 || x + 2 > right || y < top + 2 || y + 2 > bottom)
        image.pixels[uint64_t{y} * image.width + x] = {red, green, blue, 255};
}

std::string hexadecimal(const std::array<uint8_t, 3>& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour[0], colour[1], colour[2]);
  return text;
}

}  // namespace

std::vector<Outline> outlinesOf(const terrain::Scene& scene) {
  std::vector<Outline> outlines;
  const glm::dvec2 spacing_m = spacingOf(scene);
  const auto add = [&](std::string name, const proto::LatticeWindow& window, const std::string& residual) {
    outlines.push_back({std::move(name), window, kColours[outlines.size() % kColours.size()],
                        resolutionOf(window, spacing_m) + residual});
  };
  for (const terrain::SceneInput& input : scene.inputs()) {
    char residual[48] = ", residual not known";
    if (!std::isnan(input.residual_m))
      std::snprintf(residual, sizeof residual, ", residual at most %g m", input.residual_m);
    add(input.name, input.window, residual);
  }
  for (const proto::Epoch& epoch : scene.epochs().epochs().all())
    if (!epoch.moved.isEmpty()) add("epoch " + dateText(epoch.time), epoch.moved, "");
  return outlines;
}

Result<terrain::Image> drawMap(const std::shared_ptr<const terrain::Scene>& scene,
                               const std::vector<Outline>& outlines) {
  const auto shading = terrain::Shading::of(scene);
  if (!shading.ok()) return shading.error();
  const MapScale scale = scaleOf(*scene);
  terrain::Image image{scale.width, scale.height, {}};
  image.pixels.reserve(uint64_t{scale.width} * scale.height);
  drawGround(*scene, *shading, scale, image);
  // The first counts where inputs overlap, so it is drawn over the others.
  for (auto outline = outlines.rbegin(); outline != outlines.rend(); ++outline) drawOutline(*outline, scale, image);
  return image;
}

Status writeMap(const std::shared_ptr<const terrain::Scene>& scene, const std::vector<Outline>& outlines,
                const std::filesystem::path& output) {
  if (output.extension() != ".png")
    return Error{ErrorCode::kUnsupported, output.string() + ": the name of a map must end in .png"};
  if (Status s = checkOutput(output, "map"); !s.ok()) return s;
  const auto image = drawMap(scene, outlines);
  if (!image.ok()) return image.error();
  const auto bytes = terrain::encodePng(*image);
  if (!bytes.ok()) return bytes.error();
  auto file = terrain::NewFile::create(output, bytes->size());
  if (!file.ok()) return file.error();
  if (Status s = file->put(0, *bytes); !s.ok()) return s;
  return file->finish();
}

void printOutlines(const std::vector<Outline>& outlines) {
  for (const Outline& outline : outlines)
    std::printf("outline    %s %s: %s\n", hexadecimal(outline.colour).c_str(), outline.name.c_str(),
                outline.about.c_str());
}

nlohmann::ordered_json describeOutlines(const std::vector<Outline>& outlines) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Outline& outline : outlines)
    all.push_back({{"colour", hexadecimal(outline.colour)},
                   {"name", outline.name},
                   {"window", {outline.window.x, outline.window.y, outline.window.width, outline.window.height}},
                   {"about", outline.about}});
  return all;
}

}  // namespace foreland::apps
