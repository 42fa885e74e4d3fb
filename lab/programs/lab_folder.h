// Where the laboratory's own files lie: what node runs, modules of WebAssembly, experiments. Any thread.
#pragma once

#include <filesystem>
#include <string>

namespace foreland::lab {

// Has the folders of lab/: that of the installation which this program is of, or that of the sources it was built from.
std::filesystem::path labFolder();

// The module of this name, of the installation or of the preset `wasm`; it need not exist.
std::filesystem::path wasmModulePath(const std::string& name);

}  // namespace foreland::lab
