// Keeps GDAL to the files that the user meant (terrain/fence/file_fence.h), whatever a file names: GDAL's own file
// system asks here before it opens anything, and all others but archives are closed. Drivers that open files by
// libraries of their own (netCDF, HDF) are given no names but those that were checked.
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"
#include "terrain/dem/formats/gdal_dataset.h"
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

// Opens the rasters of a file, which messages call `name`; null if it has none that GDAL reads. Error: it names what
// must not be read. All that a VRT names, and the VRTs that it names, is looked at before: paths, and names that GDAL
// gives to a driver (NETCDF:"file":variable). Without a fence nothing is checked, here and below.
Result<GdalDataset> openFenced(const GdalFence* fence, const std::string& gdal_path, const std::string& name);
// The same of a subdataset, whose name is the file's own text: it must be one of that file.
Result<GdalDataset> openSubdataset(const GdalFence* fence, const std::string& subdataset, const std::string& gdal_path,
                                   const std::string& name);
// An Error where a file was asked for, since the last call, that is there but must not be read: whatever else became of
// what was done.
Status checkRefused(const GdalFence* fence, const std::string& name);

}  // namespace foreland::terrain
