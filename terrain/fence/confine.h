// Takes from this process what a reader of foreign files does not need, so that a mistake in a decoder (GDAL's drivers,
// Draco, image libraries) harms nothing: the second wall behind FileFence. For good, and for all threads that are
// started afterwards; call it before any other is.
//   files     Landlock: only `read` folders and files, libraries and the data of GDAL and PROJ can be read, and only
//             `write` folders written
//   the rest  seccomp: no sockets, no other programs, no look into other processes; these calls fail with EPERM
//   limits    no more memory than the machine has, no core files, a day of processor time for each processor
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace foreland::terrain {

struct Confinement {
  std::vector<std::filesystem::path> read;   // files and folders
  std::vector<std::filesystem::path> write;  // folders
};

// What the kernel could not do of it, for people; empty if all is in force.
std::vector<std::string> confine(const Confinement& confinement);

}  // namespace foreland::terrain
