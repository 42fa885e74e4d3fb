// Keeps GDAL to the files that the user meant (terrain/fence/file_fence.h), whatever a file names: GDAL's own file
// system asks here before it opens anything, and all others but archives are closed. Drivers that open files by
// libraries of their own (netCDF, HDF) are given no names but those that were checked.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "terrain/fence/file_fence.h"

namespace foreland::terrain {

// As long as one lives, GDAL reads what it allows and writes nothing but what a GdalOutput names; of several, what any
// of them allows. Any thread.
class GdalFence {
 public:
  explicit GdalFence(FileFence fence);
  ~GdalFence();
  GdalFence(const GdalFence&) = delete;
  GdalFence& operator=(const GdalFence&) = delete;

  const FileFence& files() const { return fence_; }
  // A file that is there and that was asked for but must not be read, since the last call.
  std::optional<std::filesystem::path> takeRefused() const;

 private:
  FileFence fence_;
};

// A file that GDAL may write, as long as this lives.
class GdalOutput {
 public:
  explicit GdalOutput(const std::filesystem::path& file);
  ~GdalOutput();
  GdalOutput(const GdalOutput&) = delete;
  GdalOutput& operator=(const GdalOutput&) = delete;

 private:
  std::filesystem::path file_;
};

// Called once, after GDAL's drivers are registered: closes its other file systems, and drivers that read no rasters of
// files.
void closeGdalFileSystems();

// Whether all that a VRT names, and the VRTs that it names, may be read: names that GDAL gives to a driver
// (NETCDF:"file":variable) as well as paths. Nothing else is a VRT, and may be read. Reads the file, and those.
Status checkVrt(const std::string& gdal_path, const std::string& name, const FileFence& fence);

// Whether the name of a subdataset, which is the file's own text, is one of that file.
Status checkSubdataset(const std::string& subdataset, const std::string& gdal_path, const std::string& name,
                       const FileFence& fence);

}  // namespace foreland::terrain
