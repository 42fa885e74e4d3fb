# Every library comes from Debian 12; tools/install_packages.sh lists the packages. Nothing is downloaded.
list(APPEND CMAKE_MODULE_PATH /usr/share/cmake/geographiclib)
find_package(GDAL 3.6 REQUIRED)
find_package(PROJ 9.1 REQUIRED CONFIG)
find_package(OpenEXR 3.1 REQUIRED)
find_package(GeographicLib 2.1 REQUIRED)
find_package(PNG 1.6 REQUIRED)
find_package(JPEG REQUIRED)
find_library(FORELAND_WEBP webp REQUIRED)  # comes without a CMake package
find_package(pugixml 1.13 REQUIRED)
find_package(embree 3.13 REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(OpenSSL 3.0 REQUIRED)
find_package(CURL 7.88 REQUIRED)
find_package(spdlog REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(Threads REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus 3.3 REQUIRED)
find_package(ZLIB REQUIRED)
find_library(FORELAND_BROTLI brotlienc REQUIRED)  # comes without a CMake package
# How models may be compressed, and what `foreland bench wire` compares with. zstd, which only that uses, comes without a
# CMake package.
find_package(meshoptimizer 0.18 REQUIRED)
find_package(draco 1.5 REQUIRED)
find_library(FORELAND_ZSTD zstd REQUIRED)
