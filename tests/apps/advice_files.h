// The files that advice_test.cpp makes programs speak with: elevation, pictures, models and tracks, each odd in one
// way.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace foreland::test {

namespace fs = std::filesystem;

inline void writeText(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

inline std::string gridText(double x, double y, double cell, const std::string& nodata,
                            const std::function<double(int, int)>& height) {
  std::string text = "ncols 65\nnrows 65\nxllcorner " + std::to_string(x) + "\nyllcorner " + std::to_string(y) +
                     "\ncellsize " + std::to_string(cell) + "\n" + nodata;
  for (int row = 0; row < 65; ++row)
    for (int column = 0; column < 65; ++column)
      text += std::to_string(height(column, row)) + (column == 64 ? "\n" : " ");
  return text;
}

inline std::string vrtOver(const std::string& file, const std::string& crs, const std::string& transform,
                           const std::string& more) {
  return "<VRTDataset rasterXSize=\"65\" rasterYSize=\"65\"><SRS>" + crs + "</SRS><GeoTransform>" + transform +
         "</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\">" + more +
         "<SimpleSource><SourceFilename relativeToVRT=\"1\">" + file +
         "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>";
}

inline std::string ppm(const std::function<std::array<int, 3>(int, int)>& colour) {
  std::string text = "P6\n65 65\n255\n";
  for (int y = 0; y < 65; ++y)
    for (int x = 0; x < 65; ++x)
      for (const int channel : colour(x, y)) text += static_cast<char>(channel);
  return text;
}

inline double hill(int x, int y) { return 500 + 3 * x + (y % 7); }

inline void makeElevation(const fs::path& folder) {
  writeText(folder / "hills.asc", gridText(400000, 5148000, 30, "", hill));
  writeText(folder / "degrees.asc", gridText(7.5, 46.4, 0.001, "", hill));
  writeText(folder / "void.asc", gridText(400000, 5148000, 30, "NODATA_value 500\n", [](int, int) { return 500.0; }));
  writeText(folder / "gaps.asc",
            gridText(400000, 5148000, 30, "", [](int x, int y) { return x < 20 ? -9999.0 : hill(x, y); }));
  const std::string north_up = "400000, 30, 0, 5149950, 0, -30";
  writeText(folder / "furlong.vrt", vrtOver("hills.asc", "EPSG:32632", north_up, "<UnitType>furlong</UnitType>"));
  writeText(folder / "feet.vrt", vrtOver("hills.asc", "EPSG:32632", north_up, "<UnitType>ft</UnitType>"));
  writeText(folder / "vertical.vrt", vrtOver("hills.asc", "EPSG:32617+6360", north_up, ""));
  writeText(folder / "map_in_feet.vrt", vrtOver("hills.asc", "EPSG:2264", "1500000, 100, 0, 700000, 0, -100", ""));
  writeText(folder / "untagged.vrt", vrtOver("gaps.asc", "EPSG:32632", north_up, ""));
  writeText(folder / "planet.vrt",
            vrtOver("degrees.asc", "EPSG:4326", "-180, 5.5384615384615383, 0, 90, 0, -2.7692307692307692", ""));
  writeText(folder / "turned.vrt", vrtOver("hills.asc", "EPSG:4326", "7.5, 0.001, 0.0003, 46.5, 0.0003, -0.001", ""));
  writeText(
      folder / "rotated_pole.vrt",
      vrtOver("hills.asc",
              "+proj=ob_tran +o_proj=longlat +o_lon_p=-162 +o_lat_p=39.25 +lon_0=180 +to_meter=0.0174532925199433",
              "-1, 0.01, 0, 1, 0, -0.01", ""));
  writeText(folder / "below/outside.vrt", vrtOver("../hills.asc", "EPSG:32632", north_up, ""));
  writeText(folder / "notes.txt", "no elevation");
}

inline void makePictures(const fs::path& folder) {
  writeText(folder / "noise.ppm", ppm([](int x, int y) {
              return std::array{127 + (x * 7 + y * 3) % 4, x * 37 % 256, y * 11 % 256};
            }));
  writeText(folder / "noise_rgb.ppm", ppm([](int x, int y) { return std::array{1, x * 97 % 256, y * 11 % 256}; }));
  writeText(folder / "terrarium.ppm", ppm([](int x, int y) { return std::array{130, x, y}; }));
  writeText(
      folder / "palette.vrt",
      "<VRTDataset rasterXSize=\"65\" rasterYSize=\"65\"><VRTRasterBand dataType=\"Byte\" "
      "band=\"1\"><ColorInterp>Palette"
      "</ColorInterp><ColorTable><Entry c1=\"0\" c2=\"0\" c3=\"0\" c4=\"255\"/><Entry c1=\"255\" c2=\"9\" c3=\"0\" "
      "c4=\"255\"/>"
      "</ColorTable></VRTRasterBand></VRTDataset>");
}

inline void makeModels(const fs::path& folder) {
  const auto tower = [](double x, double y, const std::string& before) {
    std::string text = before;
    for (const auto& [dx, dy, z] : {std::array{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}})
      text += "v " + std::to_string(x + dx) + " " + std::to_string(y + dy) + " " + std::to_string(z) + "\n";
    return text + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  };
  writeText(folder / "far.obj", tower(400000, 5148500, ""));
  writeText(folder / "tower.mtl", "newmtl a\nKd 1 0 0\n");
  writeText(folder / "below/tower.obj", tower(0, 0, "mtllib ../tower.mtl\nusemtl a\n"));
  writeText(folder / "below/without.obj", tower(0, 0, "mtllib lost.mtl\nusemtl a\n"));
  writeText(folder / "below/drive.obj", tower(0, 0, "mtllib D:\\models\\drive.mtl\nusemtl a\n"));
  // A tetrahedron, whose buffer is said to be packed, or not.
  std::string data = "data:application/octet-stream;base64,";
  data += "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAQIDAgAD";
  const auto gltf = [&](const std::string& extension, const std::string& used) {
    return "{\"asset\":{\"version\":\"2.0\"}," + used + "\"buffers\":[{\"byteLength\":60,\"uri\":\"" + data +
           "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48" + extension +
           "},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],\"accessors\":[{\"bufferView\":0,\"componentType\":"
           "5126,"
           "\"type\":\"VEC3\",\"count\":4},{\"bufferView\":1,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":12}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"nodes\":[{\"mesh\":0}],"
           "\"scenes\":[{\"nodes\":[0]}],\"scene\":0}";
  };
  writeText(folder / "unpacked.gltf", gltf("", ""));
  writeText(
      folder / "packed.gltf",
      gltf("",
           "\"extensionsUsed\":[\"KHR_meshopt_compression\"],\"extensionsRequired\":[\"KHR_meshopt_compression\"],"));
}

inline void makeTracks(const fs::path& folder) {
  const auto gpx = [](const std::vector<std::string>& times, double east = 7.52, const std::string& north = "46.43") {
    std::string text = "<gpx>";
    for (size_t i = 0; i < times.size(); ++i)
      text += "<trkpt lat='" + north + "' lon='" + std::to_string(east + 0.005 * static_cast<double>(i)) +
              "'><ele>1200</ele>" + (times[i].empty() ? "" : "<time>" + times[i] + "</time>") + "</trkpt>";
    return text + "</gpx>";
  };
  const std::string at = "2024-05-01T10:00:00Z";
  writeText(folder / "bare.gpx", gpx({"", "", "", ""}));
  writeText(folder / "hills.gpx", gpx({"", "", "", ""}, 7.7, "46.487"));
  writeText(folder / "still.gpx", gpx({at, at, at, at, at, at, at, at}));
  writeText(folder / "partly.gpx", gpx({at, "", "", "2024-05-01T10:05:00Z"}));
  writeText(folder / "long.gpx", gpx({at, "2024-09-01T10:00:00Z"}));
  writeText(
      folder / "above.kml",
      "<kml><Document><Placemark><LineString><altitudeMode>relativeToGround</altitudeMode><coordinates>7.52,46.43,50 "
      "7.54,46.43,50</coordinates></LineString></Placemark></Document></kml>");
}

}  // namespace foreland::test
