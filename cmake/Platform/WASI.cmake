# CMake 3.25 has no file for this platform and would warn; its defaults are right for a WebAssembly module.
