// `foreland render`: reference pictures of a scene by ray casting, at full resolution or of the section that a viewer
// would draw, and how far the one is from the other. Exit code 0 when all was written, 2 otherwise; no picture is left
// half-written. The main thread reads the clock; casting uses all processors.
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "apps/exact_sections.h"
#include "apps/options/foreign_track.h"
#include "apps/render/render_options.h"
#include "apps/render/render_views.h"
#include "apps/render/render_viewshed.h"
#include "oracle/drawn_surface.h"
#include "terrain/render/exr.h"
#include "terrain/render/parameter_lookup.h"
#include "terrain/render/picture.h"
#include "terrain/render/screen_image.h"
#include "terrain/store/file/new_file.h"

namespace foreland::apps {

namespace {

using Clock = std::chrono::steady_clock;

int fail(const Error& error) {
  std::fprintf(stderr, "foreland render: %s\n", error.message.c_str());
  return 2;
}

// What all pictures of a scene share. Full resolution is built only if it is drawn or measured against, anew for each
// scene time, and of a globe for each picture.
class Studio {
 public:
  static Result<Studio> open(const RenderOptions& options) {
    auto scene = terrain::Scene::open(options.scene);
    if (!scene.ok()) return scene.error();
    auto shading = terrain::Shading::of(*scene);
    if (!shading.ok()) return shading.error();
    auto objects = server::objectsOf(*scene);
    if (!objects.ok()) return objects.error();
    if (options.scene_clock && (*scene)->epochs().epochs().empty())
      return Error{ErrorCode::kInvalidArgument,
                   options.scene.string() + ": does not change in time, so there is no --scene-from or --scene-speed"};
    if ((*scene)->grid().isCube() && options.errors == Errors::kMeasured)
      return Error{ErrorCode::kUnsupported,
                   options.scene.string() +
                       ": is a globe, whose vertices have parameters of several faces; `foreland fly --truth` measures "
                       "errors on globes"};
    Studio studio(options, *scene, std::move(*shading), exactSections(*scene, std::move(*objects)));
    if (!options.viewshed.from) return studio;
    auto tint = ViewshedTint::of(options.viewshed, *scene);
    if (!tint.ok()) return tint.error();
    studio.tint_.emplace(std::move(*tint));
    return studio;
  }

  const terrain::Scene& scene() const { return *scene_; }

  struct Shot {
    terrain::Picture picture;
    terrain::ErrorSummary errors;
  };
  // `time` is since the flight's beginning.
  Result<Shot> take(const proto::Pose& pose, Time time) {
    if (Status s = showAt(time, pose.eye); !s.ok()) return s.error();
    const terrain::Camera camera{pose, options_->lens};
    std::optional<terrain::DrawnSurface> drawn;
    if (options_->drawn == Drawn::kSection || options_->errors == Errors::kMeasured)
      drawn = oracle::drawnSurface(
          *section_at_({.pose = pose, .lens = options_->lens, .tau_px = options_->tau_px, .scene_time = scene_time_}),
          1);
    auto picture = options_->drawn == Drawn::kFull ? full(camera) : section(camera, *drawn);
    if (!picture.ok()) return picture.error();
    if (tint_) tint_->apply(camera, scene_time_, *picture);
    if (options_->errors == Errors::kNone) return Shot{std::move(*picture), {}};
    const auto lookup = terrain::ParameterLookup::of(std::move(*drawn));
    if (!lookup.ok()) return lookup.error();
    terrain::PixelErrors errors = terrain::measureErrors(*full_, *lookup, camera);
    const terrain::ErrorSummary summary = terrain::summarise(errors, options_->tau_px);
    picture->error_px = std::move(errors.px);
    return Shot{std::move(*picture), summary};
  }

 private:
  Studio(const RenderOptions& options, std::shared_ptr<const terrain::Scene> scene, terrain::Shading shading,
         oracle::SectionAt section_at)
      : options_(&options),
        scene_(std::move(scene)),
        shading_(std::move(shading)),
        section_at_(std::move(section_at)) {}

  Status showAt(Time time, const glm::dvec3& eye) {
    const proto::Epochs& epochs = scene_->epochs().epochs();
    const Time before = scene_time_;
    if (!epochs.empty())
      scene_time_ = options_->scene_clock ? options_->scene_clock->timeAt(epochs, time) : epochs.first();
    const bool is_needed = options_->drawn == Drawn::kFull || options_->errors == Errors::kMeasured;
    const bool is_globe = scene_->grid().isCube();
    if (!is_needed || (full_ && scene_time_ == before && !is_globe)) return {};
    full_.reset();  // before the next one takes as much memory
    auto full = is_globe ? terrain::RayCaster::ofGlobe(scene_, eye) : terrain::RayCaster::ofScene(scene_, scene_time_);
    if (!full.ok()) return full.error();
    full_ = std::move(*full);
    return {};
  }

  Result<terrain::Picture> full(const terrain::Camera& camera) const {
    return terrain::takePicture(*full_, scene_->grid(), shading_, camera);
  }
  Result<terrain::Picture> section(const terrain::Camera& camera, const terrain::DrawnSurface& drawn) const {
    const auto caster = terrain::RayCaster::ofSurface(drawn);
    if (!caster.ok()) return caster.error();
    return terrain::takePicture(*caster, scene_->grid(), shading_, camera);
  }

  const RenderOptions* options_;
  std::shared_ptr<const terrain::Scene> scene_;
  terrain::Shading shading_;
  oracle::SectionAt section_at_;
  Time scene_time_;
  std::optional<terrain::RayCaster> full_;  // at scene_time_; of a globe from the eye
  std::optional<ViewshedTint> tint_;
};

Result<Bytes> encode(const terrain::Picture& picture, const std::filesystem::path& output, double tau_px) {
  if (output.extension() == ".exr")
    return terrain::encodeExr(picture.width, picture.height, terrain::channelsOf(picture));
  return terrain::encodePng(picture.error_px.empty() ? terrain::colourImage(picture)
                                                     : terrain::errorImage(picture, tau_px));
}

Status write(const Bytes& bytes, const std::filesystem::path& output) {
  auto file = terrain::NewFile::create(output, bytes.size());
  if (!file.ok()) return file.error();
  if (Status s = file->put(0, bytes); !s.ok()) return s;
  return file->finish();
}

// On standard error, one line that is written over again and again.
class ProgressLine {
 public:
  ProgressLine(Progress progress, size_t count)
      : count_(count), is_shown_(count > 1 && (progress == Progress::kAlways || isatty(STDERR_FILENO) == 1)) {}
  ~ProgressLine() {
    if (is_shown_) std::fputc('\n', stderr);
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(size_t done) const {
    if (!is_shown_) return;
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const long left = std::lround(seconds / static_cast<double>(done) * static_cast<double>(count_ - done));
    std::fprintf(stderr, "\rforeland render: %zu of %zu pictures, %ld:%02ld:%02ld left ", done, count_, left / 3600,
                 left / 60 % 60, left % 60);
    std::fflush(stderr);
  }

 private:
  size_t count_;
  bool is_shown_;
  Clock::time_point start_ = Clock::now();
};

void report(const RenderOptions& o, size_t pictures, const terrain::ErrorSummary& errors) {
  std::printf("%s: %zu picture%s of %u x %u pixels\n", o.outputs.front().c_str(), pictures, pictures == 1 ? "" : "s",
              o.lens.width_px, o.lens.height_px);
  if (o.errors == Errors::kNone) return;
  std::printf("largest error %.3f pixels; %llu of the terrain's %llu pixels over %g\n", errors.terrain_max_px,
              static_cast<unsigned long long>(errors.terrain_over_tau),
              static_cast<unsigned long long>(errors.terrain_pixels), o.tau_px);
  if (errors.objects_max_px > 0) std::printf("largest error on objects %.3f pixels\n", errors.objects_max_px);
}

Status writeAll(const terrain::Picture& picture, const RenderOptions& o, size_t number) {
  for (const std::filesystem::path& output : o.outputs) {
    const Result<Bytes> bytes = encode(picture, output, o.tau_px);
    if (!bytes.ok()) return bytes.error();
    if (Status s = write(*bytes, numbered(output, number)); !s.ok()) return s;
  }
  return {};
}

Result<terrain::ErrorSummary> takeAll(Studio& studio, const std::vector<proto::Pose>& poses, const RenderOptions& o) {
  terrain::ErrorSummary errors;
  const ProgressLine progress(o.progress, poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    const Result<Studio::Shot> shot =
        studio.take(poses[i], Time{} + Duration::seconds(o.every_s * static_cast<double>(i)));
    if (!shot.ok()) return shot.error();
    if (Status s = writeAll(shot->picture, o, i); !s.ok()) return s.error();
    errors.add(shot->errors);
    progress.show(i + 1);
  }
  return errors;
}

int render(const RenderOptions& o) {
  std::optional<client::Track> track;
  if (o.track) {
    Result<client::Track> read = readForeignTrack(*o.track);
    if (!read.ok()) return fail(read.error());
    track = std::move(*read);
  }
  Result<Studio> studio = Studio::open(o);
  if (!studio.ok()) return fail(studio.error());
  const Result<Views> views = viewsOf(o, track, studio->scene());
  if (!views.ok()) return fail(views.error());
  for (const std::string& note : views->notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  const Result<terrain::ErrorSummary> errors = takeAll(*studio, views->poses, o);
  if (!errors.ok()) return fail(errors.error());
  report(o, views->poses.size(), *errors);
  return 0;
}

}  // namespace

}  // namespace foreland::apps

int main(int argc, char** argv) {
  const foreland::apps::ParsedRenderOptions parsed = foreland::apps::parseRenderOptions(argc, argv);
  return parsed.exit_code ? *parsed.exit_code : foreland::apps::render(parsed.options);
}
