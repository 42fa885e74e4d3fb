// Files of strangers that name others: of the machine, of the network, to be written. Whatever they are, nothing
// outside of their folder is opened or made, and nothing connects; the kernel tells (inotify, a listening socket). Both
// walls are tested apart: the readers' own (FileFence, GDAL's file systems), and what the process may do at all
// (confine). Without either, most of these files do what they are meant to, or they would prove nothing.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "terrain/dem/write.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/watched_folder.h"

namespace foreland::terrain {
namespace {

namespace fs = std::filesystem;

// A folder with what must not be read, and a port that must not be connected to.
class Outside {
 public:
  Outside() {
    auto secret = createElevationFile({file("secret.tif"), 20, 20, 30});
    EXPECT_TRUE(secret.ok() && (*secret)->writeRows(20, std::vector<float>(400, 4242)).ok() &&
                (*secret)->finish().ok());
    std::ofstream(file("secret.bin")) << std::string(4000, 'x');
    std::ofstream(file("secret.nc")) << std::string("CDF\x01", 4) << std::string(400, '\0');
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 16), 0);
    socklen_t size = sizeof address;
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    acceptor_ = std::jthread([this] {
      for (int connection; (connection = accept(listener_, nullptr, nullptr)) >= 0; close(connection)) ++connections_;
    });
  }
  ~Outside() {
    shutdown(listener_, SHUT_RDWR);  // which ends accept()
    acceptor_.join();
    close(listener_);
  }
  std::string file(const std::string& name) const { return folder_.path() / name; }
  std::string http() const { return "http://127.0.0.1:" + std::to_string(port_); }
  fs::path folder() const { return folder_.path(); }

  // What was done outside since the last call: "" if nothing.
  std::string events() {
    std::string out = folder_.events();
    if (connections_.exchange(0) > 0) out += "connected; ";
    return out;
  }

 private:
  test::WatchedFolder folder_;
  int listener_ = -1;
  uint16_t port_ = 0;
  std::atomic<int> connections_{0};
  std::jthread acceptor_;
};

std::string vrt(const std::string& band, const std::string& attributes = "") {
  return "<VRTDataset rasterXSize=\"20\" rasterYSize=\"20\"" + attributes +
         "><GeoTransform>400000, 30, 0, 5150000, 0, -30</GeoTransform>" + band + "</VRTDataset>";
}
std::string simple(const std::string& source, const std::string& relative = "0") {
  return vrt("<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename relativeToVRT=\"" +
             relative + "\">" + source + "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>");
}
std::string raw(const std::string& source, const std::string& relative) {
  return vrt(
      "<VRTRasterBand dataType=\"Byte\" band=\"1\" subClass=\"VRTRawRasterBand\"><SourceFilename relativetoVRT=\"" +
      relative + "\">" + source +
      "</SourceFilename><ImageOffset>0</ImageOffset><PixelOffset>1</PixelOffset><LineOffset>20</LineOffset></"
      "VRTRasterBand>");
}

// By name: what is in the folder beside `input`, which is read.
struct Hostile {
  std::string suffix, text;
};

std::map<std::string, Hostile> hostileFiles(const Outside& outside, const fs::path& folder) {
  const std::string secret = outside.file("secret.tif"), up = fs::relative(secret, folder), http = outside.http();
  const std::string in_quotes = "&quot;";
  std::map<std::string, Hostile> files{
      {"raw, absolute", {".vrt", raw(outside.file("secret.bin"), "0")}},
      {"raw, upwards", {".vrt", raw(fs::relative(outside.file("secret.bin"), folder), "1")}},
      {"source, absolute", {".vrt", simple(secret)}},
      {"source, upwards", {".vrt", simple(up, "1")}},
      {"source, its name too long", {".vrt", simple(outside.file(std::string(5000, 'x')))}},
      {"source, by a link", {".vrt", simple("link.tif", "1")}},
      {"source, by a link to a folder", {".vrt", simple("folder/secret.tif", "1")}},
      {"nested", {".vrt", simple("inner.vrt", "1")}},
      {"curl", {".vrt", simple("/vsicurl/" + http + "/x.tif")}},
      {"curl, streaming", {".vrt", simple("/vsicurl_streaming/" + http + "/x.tif")}},
      {"curl in gzip", {".vrt", simple("/vsigzip//vsicurl/" + http + "/x.gz")}},
      {"curl in zip", {".vrt", simple("/vsizip/{/vsicurl/" + http + "/x.zip}/x.tif")}},
      {"zip outside", {".vrt", simple("/vsizip/{" + secret + "}/x.tif")}},
      {"subfile", {".vrt", simple("/vsisubfile/0_400," + secret)}},
      {"netCDF, network", {".vrt", simple("NETCDF:" + in_quotes + http + "/x.nc" + in_quotes + ":z")}},
      {"netCDF, file", {".vrt", simple("NETCDF:" + in_quotes + outside.file("secret.nc") + in_quotes + ":z")}},
      {"netCDF, behind blanks",
       {".vrt", std::string(900, ' ') + simple("NETCDF:" + in_quotes + outside.file("secret.nc") + in_quotes + ":z")}},
      {"HDF5, file", {".vrt", simple("HDF5:" + in_quotes + outside.file("secret.bin") + in_quotes + "://z")}},
      {"directory of a TIFF", {".vrt", simple("GTIFF_DIR:1:" + secret)}},
      {"derived", {".vrt", simple("DERIVED_SUBDATASET:AMPLITUDE:" + secret)}},
      {"dataset as a text",
       {".vrt", simple("&lt;VRTDataset rasterXSize=\"20\" rasterYSize=\"20\"&gt;&lt;VRTRasterBand dataType=\"Float32\" "
                       "band=\"1\"&gt;&lt;SimpleSource&gt;&lt;SourceFilename&gt;" +
                       secret +
                       "&lt;/SourceFilename&gt;&lt;SourceBand&gt;1&lt;/SourceBand&gt;&lt;/SimpleSource&gt;&lt;/"
                       "VRTRasterBand&gt;&lt;/VRTDataset&gt;")}},
      {"warped",
       {".vrt",
        vrt("<VRTRasterBand dataType=\"Float32\" band=\"1\" "
            "subClass=\"VRTWarpedRasterBand\"/><BlockXSize>20</BlockXSize><BlockYSize>20</BlockYSize>"
            "<GDALWarpOptions><WarpMemoryLimit>1e6</WarpMemoryLimit><ResampleAlg>NearestNeighbour</"
            "ResampleAlg><WorkingDataType>Float32</WorkingDataType>"
            "<SourceDataset relativeToVRT=\"0\">" +
                secret +
                "</SourceDataset><Transformer><GenImgProjTransformer><SrcGeoTransform>400000,30,0,5150000,0,-30</"
                "SrcGeoTransform>"
                "<SrcInvGeoTransform>-13333.3,0.03333,0,171666,0,-0.03333</"
                "SrcInvGeoTransform><DstGeoTransform>400000,30,0,5150000,0,-30</DstGeoTransform>"
                "<DstInvGeoTransform>-13333.3,0.03333,0,171666,0,-0.03333</DstInvGeoTransform></"
                "GenImgProjTransformer></Transformer>"
                "<BandList><BandMapping src=\"1\" dst=\"1\"/></BandList></GDALWarpOptions>",
            " subClass=\"VRTWarpedDataset\"")}},
      {"WMS",
       {".xml", "<GDAL_WMS><Service name=\"TMS\"><ServerUrl>" + http +
                    "/${z}/${x}/${y}.png</ServerUrl></Service><DataWindow><UpperLeftX>0</UpperLeftX>"
                    "<UpperLeftY>600</UpperLeftY><LowerRightX>600</LowerRightX><LowerRightY>0</LowerRightY><SizeX>20</"
                    "SizeX><SizeY>20</SizeY></DataWindow>"
                    "<Projection>EPSG:32632</Projection><BandsCount>1</BandsCount></GDAL_WMS>"}},
      {"MRF that writes",
       {".mrf",
        "<MRF_META><CachedSource><Source>" + secret +
            "</Source></CachedSource><Raster><Size x=\"20\" y=\"20\" c=\"1\"/><PageSize x=\"20\" y=\"20\" c=\"1\"/>"
            "<DataType>Float32</DataType><Compression>NONE</Compression><DataFile>" +
            outside.file("written.dat") + "</DataFile><IndexFile>" + outside.file("written.idx") +
            "</IndexFile></Raster></MRF_META>"}},
      {"DIMAP",
       {".dim",
        "<Dimap_Document><Metadata_Id><METADATA_FORMAT "
        "version=\"1.1\">DIMAP</METADATA_FORMAT></Metadata_Id><Raster_Dimensions><NCOLS>20</NCOLS><NROWS>20</NROWS>"
        "<NBANDS>1</NBANDS></Raster_Dimensions><Data_Access><Data_File><DATA_FILE_PATH href=\"" +
            secret + "\"/></Data_File></Data_Access></Dimap_Document>"}},
      {"ISIS label",
       {".lbl", "Object = IsisCube\n  Object = Core\n    ^Core = " + outside.file("secret.bin") +
                    "\n    StartByte = 1\n    Format = BandSequential\n    Group = Dimensions\n"
                    "      Samples = 20\n      Lines = 20\n      Bands = 1\n    End_Group\n    Group = Pixels\n      "
                    "Type = UnsignedByte\n      ByteOrder = Lsb\n"
                    "      Base = 0\n      Multiplier = 1\n    End_Group\n  End_Object\nEnd_Object\nEnd\n"}},
  };
  return files;
}

class HostileFiles : public ::testing::TestWithParam<std::string> {
 protected:
  // Reads every file with these walls, and returns what happened outside by name.
  std::map<std::string, std::string> read(const std::string& walls) {
    std::map<std::string, std::string> happened;
    for (const auto& [name, file] : hostileFiles(outside_, folder_.path())) {
      const fs::path input = folder_ / ("input" + file.suffix);
      test::spit(input, {file.text.begin(), file.text.end()});
      (void)outside_.events();
      const auto ended = test::runProgram(FORELAND_READ_FOREIGN, {walls, input.string()});
      said_[name] = ended.output;
      is_read_[name] = ended.exit_code == 0;
      if (said_[name].starts_with("missing:")) is_confined_ = false;
      if (std::string events = outside_.events(); !events.empty()) happened[name] = events;
      fs::remove(input);
    }
    return happened;
  }

  void SetUp() override {
    fs::create_symlink(outside_.file("secret.tif"), folder_ / "link.tif");
    fs::create_directory_symlink(outside_.folder(), folder_ / "folder");
    const std::string inner = simple(outside_.file("secret.tif"));
    test::spit(folder_ / "inner.vrt", {inner.begin(), inner.end()});
  }

  Outside outside_;
  test::TemporaryFolder folder_;
  std::map<std::string, std::string> said_;
  std::map<std::string, bool> is_read_;
  bool is_confined_ = true;
};

std::string listOf(const std::map<std::string, std::string>& happened) {
  std::string out;
  for (const auto& [name, events] : happened) out += name + ": " + events + "\n";
  return out;
}

TEST_F(HostileFiles, DoWhatTheyAreMeantToWithoutWalls) {
  const auto happened = read("none");
  EXPECT_GE(happened.size(), 15u) << listOf(happened);
}

TEST_F(HostileFiles, AreRefusedByNameByTheReaders) {
  EXPECT_EQ(listOf(read("first")), "");
  for (const auto& [name, is_read] : is_read_) {
    EXPECT_FALSE(is_read) << name;
    EXPECT_NE(said_[name].find("input."), std::string::npos) << name << ": " << said_[name];
  }
  EXPECT_NE(said_["source, absolute"].find("--allow-files-from " + outside_.folder().string()), std::string::npos)
      << said_["source, absolute"];
  EXPECT_NE(said_["nested"].find("secret.tif"), std::string::npos) << said_["nested"];
}

TEST_F(HostileFiles, ReachNothingFromAConfinedProcess) {
  const auto happened = read("second");
  if (!is_confined_) GTEST_SKIP() << "this kernel confines no processes";
  EXPECT_EQ(listOf(happened), "");
}

// What lies in the folder of the file, or below, is read with both walls.
TEST_F(HostileFiles, MayNameFilesOfTheirFolder) {
  fs::create_directory(folder_ / "below");
  fs::copy_file(outside_.file("secret.tif"), folder_ / "below" / "own.tif");
  const std::string text = simple("below/own.tif", "1");
  test::spit(folder_ / "input.vrt", {text.begin(), text.end()});
  const auto ended = test::runProgram(FORELAND_READ_FOREIGN, {"both", folder_ / "input.vrt"});
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
}

}  // namespace
}  // namespace foreland::terrain
