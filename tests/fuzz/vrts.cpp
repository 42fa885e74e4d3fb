// A virtual raster that a stranger wrote: through the look at all that it names, and opened with the drivers and file
// systems that there are, beside a sound raster of its own. Whatever it says, nothing outside of its folder is opened,
// made or listed (the kernel tells), and it is read, or refused by a message that names it. The input is its text,
// where bytes from 128 on stand for words (kWords): random changes of markup alone are hardly ever markup.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "terrain/dem/open.h"
#include "terrain/dem/write.h"
#include "tests/support/files.h"
#include "tests/support/watched_folder.h"

namespace {

using namespace foreland;

constexpr std::string_view kWords[] = {
    "<VRTDataset rasterXSize=\"20\" rasterYSize=\"20\">",
    "<VRTDataset rasterXSize=\"20\" rasterYSize=\"20\" subClass=\"VRTWarpedDataset\">",
    "</VRTDataset>",
    "<GeoTransform>400000, 30, 0, 5150000, 0, -30</GeoTransform>",
    "<SRS>EPSG:32632</SRS>",
    "<VRTRasterBand dataType=\"Float32\" band=\"1\">",
    "<VRTRasterBand dataType=\"Byte\" band=\"1\" subClass=\"VRTRawRasterBand\">",
    "<VRTRasterBand dataType=\"Float32\" band=\"1\" subClass=\"VRTDerivedRasterBand\">",
    "<VRTRasterBand dataType=\"Float32\" band=\"1\" subClass=\"VRTPansharpenedRasterBand\">",
    "</VRTRasterBand>",
    "<SimpleSource>",
    "</SimpleSource>",
    "<ComplexSource>",
    "</ComplexSource>",
    "<SourceFilename relativeToVRT=\"1\">",
    "<SourceFilename relativeToVRT=\"0\">",
    "<SourceFilename>",
    "</SourceFilename>",
    "<SourceDataset relativeToVRT=\"1\">",
    "<SourceDataset>",
    "</SourceDataset>",
    "<SourceBand>1</SourceBand>",
    "<SourceBand>mask,1</SourceBand>",
    "<ImageOffset>0</ImageOffset><PixelOffset>1</PixelOffset><LineOffset>20</LineOffset>",
    "<Overview>",
    "</Overview>",
    "<MaskBand>",
    "</MaskBand>",
    "<GDALWarpOptions>",
    "</GDALWarpOptions>",
    "<PixelFunctionType>sum</PixelFunctionType>",
    "<PixelFunctionLanguage>Python</PixelFunctionLanguage><PixelFunctionCode>import os</PixelFunctionCode>",
    "<OpenOptions><OOI key=\"",
    "</OOI></OpenOptions>",
    "<Metadata><MDI key=\"",
    "</MDI></Metadata>",
    "<NoDataValue>0</NoDataValue>",
    "<SrcRect xOff=\"0\" yOff=\"0\" xSize=\"20\" ySize=\"20\"/><DstRect xOff=\"0\" yOff=\"0\" xSize=\"20\" "
    "ySize=\"20\"/>",
    "<Group name=\"/\">",
    "</Group>",
    "<Array name=\"a\"><DataType>Float32</DataType><Dimension size=\"20\"/><Dimension size=\"20\"/>",
    "</Array>",
    "own.tif",
    "input.vrt",
    "inner.vrt",
    "link.tif",
    "folder/secret.tif",
    "OUTSIDE/secret.tif",
    "OUTSIDE/secret.bin",
    "OUTSIDE",
    "../",
    "/vsizip/",
    "/vsigzip/",
    "/vsitar/",
    "/vsisubfile/0_400,",
    "/vsimem/",
    "/vsicurl/http://127.0.0.1:9/x.tif",
    "/vsistdin/",
    "/vsicrypt/key=x,file=",
    "/vsisparse/",
    "{",
    "}",
    "NETCDF:",
    "HDF5:",
    "GTIFF_DIR:1:",
    "DERIVED_SUBDATASET:AMPLITUDE:",
    "vrt://",
    "ZARR:",
    "GPKG:",
    "NITF_IM:0:",
    "&quot;",
    "&lt;",
    "&gt;",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<?xml version=\"1.0\" encoding=\"",
    "?>",
};

struct Place {
  test::WatchedFolder outside;
  test::TemporaryFolder folder;

  Place() {
    writeHeights(outside.path() / "secret.tif");
    std::ofstream(outside.path() / "secret.bin") << std::string(4000, 'x');
    writeHeights(folder / "own.tif");
    std::filesystem::create_symlink(outside.path() / "secret.tif", folder / "link.tif");
    std::filesystem::create_directory_symlink(outside.path(), folder / "folder");
    std::ofstream(folder / "inner.vrt") << "<VRTDataset rasterXSize=\"20\" rasterYSize=\"20\"><VRTRasterBand "
                                           "dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename>"
                                        << (outside.path() / "secret.tif").string()
                                        << "</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>";
    (void)outside.events();
  }
  static void writeHeights(const std::filesystem::path& path) {
    auto file = terrain::createElevationFile({path, 20, 20, 30});
    CHECK_TRUE(file.ok() && (*file)->writeRows(20, std::vector<float>(400, 42)).ok() && (*file)->finish().ok());
  }
  std::string textOf(std::span<const uint8_t> input) const {
    std::string text;
    for (const uint8_t byte : input) {
      const std::string_view word = byte < 128 ? std::string_view() : kWords[(byte - 128) % std::size(kWords)];
      if (byte < 128)
        text += static_cast<char>(byte);
      else if (word.starts_with("OUTSIDE"))
        text += outside.path().string() + std::string(word.substr(7));
      else
        text += word;
    }
    return text;
  }
};

// Some rows; a file may say that it has more than fit into memory.
void readSome(terrain::ElevationSource& source) {
  constexpr uint64_t kMost = 1u << 20;
  const terrain::ElevationInfo& info = source.info();
  if (info.width > kMost) return;
  const auto rows = static_cast<uint32_t>(std::min<uint64_t>(info.height, kMost / std::max(info.width, 1u)));
  std::vector<float> heights(uint64_t{info.width} * rows);
  (void)source.readRows(0, rows, heights);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static Place place;
  const std::filesystem::path file = place.folder / "input.vrt";
  std::filesystem::remove(file);
  std::ofstream(file) << place.textOf({data, size});
  auto source = terrain::openElevation({file}, {});
  if (source.ok())
    readSome(**source);
  else
    CHECK_TRUE(source.error().message.find("input.vrt") != std::string::npos);
  source = Error{};  // closed, before what was done is looked at
  const std::string events = place.outside.events();
  CHECK_EQ(events, "");
  return 0;
}
