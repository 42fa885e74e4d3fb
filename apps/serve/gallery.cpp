#include "apps/serve/gallery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

#include "apps/serve/scene_picture.h"
#include "server/net/http/scene_paths.h"

namespace foreland::apps {
namespace {

// Without scripts, and of figures alone where words would need a language.
constexpr std::string_view kPage = R"(<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Foreland</title>
<link rel="icon" href="data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 32 32'%3E%3Cpath d='M1 27 12 8l5 8 3-5 11 16z' fill='%235c8dc9'/%3E%3C/svg%3E">
<style>
:root {{ color-scheme: dark; font: 16px/1.4 system-ui, sans-serif; background: #10151c; color: #e8edf2; }}
body {{ margin: 0 auto; padding: 2rem 1.25rem 3rem; max-width: 76rem; }}
h1 {{ font-weight: 600; font-size: 1.5rem; margin: 0 0 1.25rem; }}
ul {{ list-style: none; margin: 0; padding: 0; display: grid; gap: 1.25rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); }}
a {{ display: block; height: 100%; color: inherit; text-decoration: none; background: #1a222c; border-radius: .6rem; overflow: hidden; outline-offset: 3px; }}
a:hover {{ background: #243040; }}
a:focus-visible {{ outline: 3px solid #7ab8ff; }}
img {{ display: block; width: 100%; aspect-ratio: 16 / 10; object-fit: cover; background: #2a3441; }}
h2 {{ font-size: 1.05rem; font-weight: 600; margin: .8rem 1rem .1rem; overflow-wrap: anywhere; }}
p {{ margin: 0 1rem 1rem; color: #aab6c3; font-size: .875rem; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }}
@media (prefers-reduced-motion: no-preference) {{ a {{ transition: background .15s; }} }}
</style>
<body><main><h1>Foreland</h1><ul>
{}</ul></main></body></html>
)";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string lengthText(double metres) {
  if (metres < 1000) return fmt::format("{:.3g} m", metres);
  return metres < 99'500 ? fmt::format("{:.3g} km", metres / 1000) : fmt::format("{:.0f} km", metres / 1000);
}

std::string aboutScene(const terrain::Scene& scene) {
  const proto::Frame& f = scene.frame();
  const proto::GridShape& s = scene.grid().shape();
  const auto [low, high] = scene.heightRange();
  const std::string heights =
      fmt::format("{:.0f} \u2013 {:.0f} m", low * f.height_quantum_m, high * f.height_quantum_m);
  if (s.is_cube) return fmt::format("\u2300 {}, {}", lengthText(2 * f.semi_major_m), heights);
  glm::dvec2 spacing_m(glm::length(f.axis_x_m), glm::length(f.axis_y_m));
  if (f.kind != proto::FrameKind::kPlanar) {
    const double latitude = f.latitude0_rad + 0.5 * s.samples_y * f.latitude_step_rad;
    spacing_m = f.semi_major_m * glm::dvec2(f.longitude_step_rad * std::cos(latitude), f.latitude_step_rad);
  }
  return fmt::format("{} \u00d7 {}, {}", lengthText(spacing_m.x * (s.samples_x - 1.0)),
                     lengthText(spacing_m.y * (s.samples_y - 1.0)), heights);
}

}  // namespace

Result<std::vector<std::string>> galleryNames(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const auto& file : files)
    names.push_back(file.extension() == ".fls" ? file.stem().string() : file.filename().string());
  if (Status s = server::checkSceneNames(names); !s.ok()) return s.error();
  return names;
}

Status checkDifferent(const std::vector<GalleryScene>& scenes) {
  for (size_t i = 0; i < scenes.size(); ++i)
    for (size_t k = 0; k < i; ++k)
      if (scenes[i].scene->id() == scenes[k].scene->id())
        return Error{ErrorCode::kInvalidArgument, fmt::format("'{}' and '{}' are the same scene; leave one of them out",
                                                              scenes[k].name, scenes[i].name)};
  return {};
}

std::map<std::string, std::string> galleryFiles(const std::vector<GalleryScene>& scenes) {
  std::map<std::string, std::string> files;
  std::string items;
  for (const GalleryScene& s : scenes) {
    files[fmt::format("/{}/picture.png", s.name)] = server::encodePng(scenePicture(*s.scene));
    items += fmt::format(
        "<li><a href=\"{0}/\"><img src=\"{0}/picture.png\" alt=\"\"><h2>{0}</h2><p>{1}<br>{2}</p></a></li>\n", s.name,
        escaped(s.scene->origin().title), escaped(aboutScene(*s.scene)));
  }
  files["/scenes.html"] = fmt::format(kPage, items);
  return files;
}

}  // namespace foreland::apps
