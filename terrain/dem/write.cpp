#include "terrain/dem/write.h"

#include <string>
#include <system_error>

#include "terrain/dem/formats/write_formats.h"

namespace foreland::terrain {

Result<std::unique_ptr<ElevationWriter>> createElevationFile(const ElevationFile& file) {
  std::error_code failed;
  const std::filesystem::path folder = file.path.has_parent_path() ? file.path.parent_path() : ".";
  if (std::filesystem::is_directory(file.path, failed))
    return Error{ErrorCode::kInvalidArgument, file.path.string() + ": a directory; name a file in it"};
  if (!std::filesystem::is_directory(folder, failed))
    return Error{ErrorCode::kNotFound, file.path.string() + ": there is no directory " + folder.string()};
  const std::string suffix = file.path.extension().string();
  if (suffix == ".exr") return createExr(file);
  if (suffix == ".tif" || suffix == ".tiff") return createTiff(file);
  return Error{ErrorCode::kUnsupported,
               file.path.string() + ": the name must end in .exr or .tif, which says the format"};
}

}  // namespace foreland::terrain
