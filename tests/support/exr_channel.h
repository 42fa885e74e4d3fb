// A layer's channel of an OpenEXR picture, as other programs read it.
#pragma once

#include <filesystem>
#include <vector>

namespace foreland::test {

// Four bytes a pixel, row by row from the top; none, and a failure, if there is no such channel.
std::vector<float> readChannel(const std::filesystem::path& path, const char* name);

}  // namespace foreland::test
