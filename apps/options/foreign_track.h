// Reads a recorded flight in a confined child (terrain/fence): the programs that take `--track` need sockets, or other
// files, for themselves. To be called before threads are started.
#pragma once

#include <filesystem>

#include "base/bytes.h"
#include "base/result.h"
#include "client/fly/tracks/track.h"

namespace foreland::apps {

using TrackReader = Result<client::Track> (*)(const std::filesystem::path& path);

// What client::readTrack says of the file. The child may read this file alone. `read`: for tests.
Result<client::Track> readForeignTrack(const std::filesystem::path& path, TrackReader read = client::readTrack);

// How the child answers: any bytes end in what a reader may return, or in an Error that names the file.
Bytes encodeTrack(const Result<client::Track>& track);
Result<client::Track> decodeTrack(ByteSpan bytes, const std::string& name);

}  // namespace foreland::apps
