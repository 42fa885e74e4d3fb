// How to understand elevation files where they do not say it themselves: the user's choices. Plain data.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace foreland::terrain {

enum class FrameChoice : uint8_t {
  kAuto,        // as the file's reference system says
  kPlanar,      // geographic input is flattened at its middle latitude (small areas only)
  kGeographic,  // coordinates without a reference system are degrees on WGS84
};

enum class HeightEncoding : uint8_t {
  kPlain,       // one band of heights
  kTerrarium,   // three bands of 8 bits: red * 256 + green + blue / 256 - 32768 metres
  kTerrainRgb,  // the same: (red * 65536 + green * 256 + blue) / 10 - 10000 metres
};

// Of inputs of several grids: whether their lattice is as fine everywhere as where it is finest.
enum class LatticeChoice : uint8_t {
  kAuto,    // where it would have far more positions than the inputs have samples, it is fine in places only
  kWhole,   // everywhere
  kSparse,  // in places only
};

// A raster of another grid that is laid over the inputs.
struct InsetFile {
  std::filesystem::path file;
  int priority = 0;  // higher ones lie over lower ones, and of equals the one that is named first
};

struct OpenOptions {
  std::optional<double> nodata{};        // instead of the file's own value
  std::optional<double> spacing_m{};     // for inputs without a reference system (EXR, images)
  std::optional<std::string> channel{};  // EXR channel, band number, or variable of a file with several
  FrameChoice frame = FrameChoice::kAuto;
  HeightEncoding encoding = HeightEncoding::kPlain;  // of pictures whose colours are heights it is found out
  std::optional<double> height_unit{};               // metres a unit of the heights, whatever the file says
  // What heights count from (terrain/dem/vertical/height_reference.h): of every input; of some inputs, by their names
  // as they are opened; and of the result. By default as reference systems say, and as the first input that states it.
  std::optional<std::string> vertical{};
  std::map<std::string, std::string> vertical_of{};
  std::optional<std::string> scene_vertical{};
  std::vector<InsetFile> insets{};
  // Over how many metres their edges are mixed with what lies below; by default four samples of the inputs, and at most
  // an eighth of the inset's shorter side.
  std::optional<double> feather_m{};
  // How far the lattice's heights may be from an inset's samples, before they are rounded; by default the lattice is as
  // fine as the finest inset.
  std::optional<double> residual_m{};
  LatticeChoice lattice = LatticeChoice::kAuto;
  bool keeps_map = false;  // whether a file's map stays as it is, although its distances are not those of the ground
  // Beside its own folder, what a file may name files of (terrain/fence/file_fence.h); without the fence, in tests of
  // what else holds, any.
  std::vector<std::filesystem::path> allowed_folders{};
  bool is_fenced = true;
};

}  // namespace foreland::terrain
