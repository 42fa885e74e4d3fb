// Small elevation files for tests, made on the spot in a folder that goes with the fixture.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "terrain/dem/open.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

class DemFiles : public ::testing::Test {
 protected:
  DemFiles() : folder_(std::filesystem::temp_directory_path() / ("foreland-dem-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~DemFiles() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  // An ASCII grid of columns x rows samples; the value at (column, row from the top) is 100 * row + column.
  std::filesystem::path asciiGrid(const std::string& name, int columns, int rows, const std::string& header_place) {
    std::string text = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) + "\n" + header_place;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) text += std::to_string(100 * r + c) + " ";
      text += "\n";
    }
    return write(name, text);
  }

  // An SRTM tile of 3 arc seconds; height = 10 + column + row, from the top; voids where asked.
  std::filesystem::path srtmTile(const std::string& name, int first_void_row = 1201) {
    std::string bytes(size_t{1201} * 1201 * 2, '\0');
    for (int r = 0; r < 1201; ++r)
      for (int c = 0; c < 1201; ++c) {
        const auto h = static_cast<uint16_t>(r >= first_void_row ? -32768 : 10 + c + r);
        bytes[2 * (size_t(r) * 1201 + c)] = static_cast<char>(h >> 8);
        bytes[2 * (size_t(r) * 1201 + c) + 1] = static_cast<char>(h);
      }
    return write(name, bytes);
  }

  static Result<std::unique_ptr<ElevationSource>> open(const std::filesystem::path& path,
                                                       const OpenOptions& options = {}) {
    return openElevation({path}, options);
  }

  static std::vector<float> readAll(ElevationSource& source) {
    std::vector<float> heights(size_t{source.info().width} * source.info().height);
    const Status status = source.readRows(0, source.info().height, heights);
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().message);
    return heights;
  }

  static bool hasNote(const ElevationSource& source, const std::string& words) {
    for (const std::string& note : source.info().notes)
      if (note.find(words) != std::string::npos) return true;
    return false;
  }

  std::filesystem::path folder_;
};

// The error names the file and holds the words.
inline void expectRefusal(const Result<std::unique_ptr<ElevationSource>>& result, const std::filesystem::path& path,
                          const std::string& words) {
  ASSERT_FALSE(result.ok()) << path;
  EXPECT_NE(result.error().message.find(path.filename().string()), std::string::npos) << result.error().message;
  EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
}

}  // namespace foreland::terrain
