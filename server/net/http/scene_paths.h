// Where the scenes of a server with several lie: below a path of their own each, /NAME/, as if that were a server with
// one. Pure; any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland::server {

// An Error says why a name will not do in an address: letters, digits, '.', '_' and '-' will, but for a '.' at the
// beginning, for names that the server answers itself (/metrics), and for two scenes of one name.
Status checkSceneNames(std::span<const std::string> names);

struct ScenePath {
  size_t scene = 0;
  std::string_view rest;  // of the path, from the slash after the name on; empty if it ends with the name
};
// Of a path, without query and percent-encoding. With no names there is one scene, which all paths belong to; otherwise
// nothing if the path begins with no name.
std::optional<ScenePath> scenePathOf(std::string_view path, std::span<const std::string> names);

// Of which scene a WebSocket at a request's target is to show the ground: /NAME/fly, /NAME/ and /NAME. With no names
// any target is of the one scene.
std::optional<size_t> sceneToFly(std::string_view target, std::span<const std::string> names);

}  // namespace foreland::server
