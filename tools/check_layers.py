#!/usr/bin/env python3
"""Proves that includes go one way, that third-party types stay in the folder that wraps them, and that only edges read a clock.

    tools/check_layers.py               checks the repository; prints each violation as FILE:LINE: ..., exits 1 if there is one
    tools/check_layers.py --self-test   plants violations in a scratch tree and proves that each one is found

The tables below are the architecture; change them together with ARCHITECTURE.md.
"""

import os
import re
import sys
import tempfile

import source_files

def top(room):
    return room.split("/")[0]


# A room is a folder; a file belongs to the deepest room that holds it. Each room sees itself and what is listed.
PROTO_ROOMS = ["proto/topology", "proto/space", "proto/section", "proto/refine/memory", "proto/refine/hidden", "proto/refine/metric",
               "proto/refine/surface", "proto/refine", "proto/codec", "proto/imagery", "proto/message"]
PROTO = ["base", *PROTO_ROOMS]
SEES = {"base": [], "transport": ["base"]}
for at, room in enumerate(PROTO_ROOMS):
    SEES[room] = ["base", *PROTO_ROOMS[:at]]
STORE = ["terrain/store/file", "terrain/store/tables", "terrain/store/coded", "terrain/store/distant", "terrain/store"]
SEES |= {
    "terrain": PROTO,  # elevation_source.h and its like: what the rooms below share
    "terrain/fence": ["base"],  # what keeps readers of foreign files to what the user meant
    "terrain/geo": [*PROTO, "terrain"],
    "terrain/store/file": [*PROTO, "terrain"],
    "terrain/store/tables": [*PROTO, "terrain", "terrain/store/file"],
    "terrain/store/coded": [*PROTO, "terrain", "terrain/store/file"],
    "terrain/store/distant": [*PROTO, "terrain", "terrain/store/file"],
    "terrain/store": [*PROTO, "terrain", "terrain/store/file", "terrain/store/tables", "terrain/store/coded", "terrain/store/distant"],
    "terrain/fetch": ["base", "terrain/store/distant"],  # stores at a distance; knows no scene
    "terrain/bounds": [*PROTO, "terrain", *STORE],
    "terrain/epochs": [*PROTO, "terrain", *STORE, "terrain/bounds"],
    "terrain/imagery": [*PROTO, "terrain", "terrain/geo", *STORE, "terrain/bounds"],
    "terrain/surface": [*PROTO, "terrain"],
    "terrain/pipeline": [*PROTO, "terrain", "terrain/geo", *STORE, "terrain/bounds", "terrain/dem/voids",
                      "terrain/epochs", "terrain/imagery", "terrain/surface", "terrain/surface_store", "terrain/objects"],
    "terrain/model": [*PROTO, "terrain", "terrain/fence"],
    "terrain/compare": [*PROTO, "terrain"],  # judges the remesher and shares no code with it
    "terrain/surface_store": [*PROTO, "terrain", *STORE, "terrain/surface"],
    "terrain/objects": [*PROTO, "terrain", *STORE, "terrain/surface", "terrain/surface_store"],
    "terrain/render": [*PROTO, "terrain", *STORE, "terrain/imagery", "terrain/surface", "terrain/surface_store", "terrain/objects",
                       "terrain/model"],  # reference pictures; shares no code with server/occlusion
}
SEES["terrain/geoid"] = ["base"]  # how far geoids lie above the ellipsoid, and where maps are on it
DEM_ROOMS = ["terrain/dem/raster", "terrain/dem/vertical", "terrain/dem/formats", "terrain/dem/pictures", "terrain/dem/mosaic", "terrain/dem/warp", "terrain/dem/insets", "terrain/dem/planet", "terrain/dem"]
for at, room in enumerate(DEM_ROOMS):
    SEES[room] = [*PROTO, "terrain", "terrain/geo", "terrain/geoid", "terrain/fence", *DEM_ROOMS[:at]]
SEES["terrain/dem/voids"] = ["base"]  # knows no file format
SEES["terrain/dem/insets"] = ["base", "terrain/dem/mosaic", "terrain/dem/voids"]  # nor where places come from
SEES["terrain/dem/planet"] = ["base", "terrain/dem/insets"]  # nor do rasters around a body
SEES["terrain/dem"] = [*SEES["terrain/dem"], "terrain/dem/voids"]
REMESH_ROOMS = ["terrain/remesh/original", "terrain/remesh/simplify", "terrain/remesh/lattice", "terrain/remesh",
                "terrain/remesh/paint"]
for at, room in enumerate(REMESH_ROOMS):
    SEES[room] = [*PROTO, "terrain", "terrain/model", "terrain/compare", "terrain/surface", "terrain/surface_store",
                  *REMESH_ROOMS[:at]]

SEES["terrain/remesh/solids"] = [*PROTO, "terrain", "terrain/surface"]  # of any surface, however it was made
SEES["terrain/synth"] = [*PROTO, "terrain"]
SEES["terrain/town"] = [*SEES["terrain/pipeline"], *REMESH_ROOMS, "terrain/remesh/solids", "terrain/model", "terrain/synth", "terrain/pipeline"]

# The server sees the terrain, but neither what reads foreign files (GDAL, OpenEXR) nor the builder.
SERVER_SEES = [*PROTO, "terrain", *STORE, "terrain/bounds", "terrain/geo", "terrain/surface",
               "terrain/surface_store", "terrain/objects"]
SERVER_ROOMS = ["server/view", "server/section", "server/embree", "server/occlusion/horizon", "server/occlusion/proofs", "server/occlusion/objects", "server/occlusion", "server/sight", "server/imagery",
                "server/sched", "server/session/input", "server/session/plan", "server/session/view", "server/session", "server/net/http", "server/net/metrics", "server/net/access", "server/net", "server"]
for at, room in enumerate(SERVER_ROOMS):
    SEES[room] = SERVER_SEES + SERVER_ROOMS[:at]

CLIENT_ROOMS = ["client/mesh/patch", "client/mesh/weights", "client/mesh/terrain", "client/mesh/objects", "client/imagery", "client/ground", "client"]
for at, room in enumerate(CLIENT_ROOMS):
    SEES[room] = [*PROTO, *CLIENT_ROOMS[:at]]
CLIENT = [*PROTO, *CLIENT_ROOMS]
SEES["client/wasm"] = CLIENT
SEES["client/fly/net"] = [*CLIENT, "transport"]
SEES["server/net"] = [*SEES["server/net"], "transport"]
SEES["client/fly/tracks"] = CLIENT
SEES["client/fly"] = [*CLIENT, "client/fly/net", "client/fly/tracks"]
SEES["client/c"] = [*CLIENT, "client/fly/net"]  # the client for other engines, whose hosts see foreland.h alone

LIBRARIES = sorted(SEES)
# The judge of what is drawn, in measurements, in the player and in tests; it knows nothing of the server.
SEES["oracle"] = [r for r in LIBRARIES if top(r) not in ("server",)]
# The real server and clients in virtual time, for tests and the laboratory.
SEES["sim"] = LIBRARIES
PRODUCT = [*LIBRARIES, "oracle"]
SEES["apps"] = PRODUCT
SEES["examples"] = LIBRARIES  # to be read: nothing that a program of one's own would not include

# The laboratory sees everything but the tests, and nothing else sees it.
SEES["lab/programs"] = ["base"]
SEES["lab/wire/peers"] = ["base", "lab/programs"]  # other makers' mesh codecs, each wrapped; knows nothing of ours
LAB_ROOMS = ["lab/programs", "lab/wire/peers", "lab"]
SEES["lab"] = [*PRODUCT, "sim", "apps", *LAB_ROOMS[:-1]]
SEES["lab/proxy"] = [*SEES["lab"], "lab"]  # the links of the world in virtual time, for real connections
SEES["lab/external"] = ["base", "proto/topology", "proto/space", "server/view", "server/sched", "sim", "lab/programs"]  # programs of the user's
for room in ("lab/animated", "lab/drape", "lab/latency", "lab/load", "lab/tiles"):
    SEES[room] = [*SEES["lab"], "lab", "lab/external"]
SEES["lab/load"] = [*SEES["lab/load"], "lab/proxy"]
SEES["lab/report"] = ["base", "lab/programs", "lab"]  # knows the tables alone
SEES["lab/rivals"] = [*PROTO, "terrain", *STORE, "lab/programs"]  # the ground and a path, for other makers' viewers
LAB_ROOMS += ["lab/external", "lab/proxy", "lab/animated", "lab/drape", "lab/latency", "lab/load", "lab/tiles", "lab/report", "lab/rivals"]
SEES["lab/apps"] = [*PRODUCT, "sim", "apps", *LAB_ROOMS]
SEES["tests/support"] = [*PRODUCT, "sim"]
SEES["tests"] = [*PRODUCT, "sim", "apps", "tests/support"]
SEES["lab/tests"] = [*PRODUCT, "sim", "apps", *LAB_ROOMS, "tests/support", "tests"]

# Who may include a third-party header. Tests may use any of them: they compare us with them.
TESTS = ["tests", "tests/support", "lab/tests"]
EDGES = ["apps", "lab", "lab/apps", *TESTS]
THIRD_PARTY = [
    (r"(gdal|ogr|cpl|vrt|gnm)[\w/]*\.h(pp)?$", "GDAL", ["terrain/dem/formats", "terrain/dem/pictures", "terrain/dem/warp", *TESTS]),
    (r"(OpenEXR|Imath)/|(Imf|Iex|IlmThread|Imath|half)\w*\.h$|openexr\w*\.h$", "OpenEXR", ["terrain/dem/formats", "terrain/render", *TESTS]),
    (r"png(conf|libconf)?\.h$", "libpng", ["terrain/model", *TESTS]),
    (r"(jpeglib\.h$|jerror\.h$|webp/)", "libjpeg or libwebp", ["terrain/model", "terrain/imagery", *TESTS]),
    (r"pugi(xml|config)\.hpp$", "pugixml", ["client/fly/tracks", *TESTS]),
    (r"GeographicLib/", "GeographicLib", ["terrain/geo", *TESTS]),
    (r"proj(_experimental|_constants)?\.h$", "PROJ", ["terrain/geoid", *TESTS]),
    (r"curl/", "libcurl", ["terrain/fetch", *TESTS]),
    (r"embree\d?/", "Embree", ["server/embree", "server/occlusion", "server/occlusion/objects", "server/sight", "terrain/render", *TESTS]),
    (r"boost/", "Boost", ["transport", "server/net/http", "server/net/access", "server/net", "client/fly/net", "lab/load", "lab/proxy", *EDGES]),
    (r"openssl/", "OpenSSL", ["transport", "server/net/access", *EDGES]),
    (r"(draco/|meshoptimizer\.h$)", "Draco or meshoptimizer", ["terrain/model", "lab/wire/peers", *TESTS]),
    (r"(zlib\.h$|brotli/)", "zlib or brotli", ["client/fly/tracks", "lab/wire/peers", "server/net/http", *TESTS]),
    (r"CLI/", "CLI11", EDGES),
    (r"toml\+\+/", "toml++", EDGES),
    (r"benchmark/", "Google Benchmark", ["lab"]),
    (r"(gtest|gmock|rapidcheck)[/.]", "a test framework", TESTS),
    (r"(spdlog|fmt|nlohmann|zstd|xxhash|tbb|oneapi)[/.]", "a library that WebAssembly lacks",
     [r for r in SEES if r not in (*CLIENT, "client/wasm")]),
    (r"(chrono|thread|mutex|shared_mutex|condition_variable|future|fstream|filesystem|iostream|stop_token)$",
     "clocks, threads, files or streams in a room that is also compiled to WebAssembly",
     [r for r in SEES if r not in (*CLIENT, "client/wasm")]),
]

CLOCK = re.compile(r"\b(steady_clock|system_clock|high_resolution_clock|clock_gettime|gettimeofday|std::time\s*\()|<ctime>")
CLOCK_ROOMS = ["server/net", "client/c", "client/fly", "client/fly/net", "sim", "lab/load", "lab/programs", *EDGES]  # sim: to time its steps; lab/load: for runs in real time; lab/programs: for answers that do not come

# Rooms of the client's package in TypeScript, and what each may import; `three` is the library. Only the worker's entry knows Node.
SCRIPT_SEES = {
    "client/js/src/core": [],
    "client/js/src/worker": ["client/js/src/core", "node", "ws"],
    "client/js/src/three": ["client/js/src/core", "client/js/src", "three"],
    "client/js/src/maplibre": ["client/js/src/core", "client/js/src", "client/js/src/three", "three", "maplibre-gl"],
    "client/js/src": ["client/js/src/core", "node", "foreland"],
    # The page uses the package by its name, as anyone does.
    "client/web/src": ["client/web/src/follow", "client/web/src/globe", "client/web/src/measure", "client/web/src/overlay", "client/web/src/record", "@foreland/client", "@takram/three-atmosphere", "dejavu-fonts-ttf", "three", "troika-three-text", "virtual"],
    "client/web/src/globe": ["geographiclib-dms", "suncalc"],  # places as text, and the sun
    "client/web/src/measure": ["@foreland/client", "geographiclib-geodesic"],
    "client/web/src/overlay": ["@foreland/client", "@tmcw/togeojson", "@xmldom/xmldom", "fflate", "proj4"],
    "client/web/src/follow": ["client/web/src/measure", "@foreland/client", "three"],  # flights and the cameras that follow them
    "client/web/src/record": ["fflate", "mediabunny"],  # what makes files of frames
}
IMPORT = re.compile(r"""^(?:import|export)\b.*?\bfrom '([^']+)';|\bimport\('([^']+)'\)""")
DOM = re.compile(r"\b(document|window)\b")
DOM_ROOMS = ["client/js/src/three", "client/js/src/maplibre", "client/web/src"]
DOM_FILES = ["client/js/src/host.ts"]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def room_of(path):
    """The deepest room that holds `path`, or None."""
    parts = path.split("/")[:-1]
    while parts:
        if "/".join(parts) in SEES:
            return "/".join(parts)
        parts.pop()
    return None


def judge_include(path, room, quoted, target):
    """What is wrong with this include, or None."""
    target_room = room_of(target)
    if quoted and ".." in target.split("/"):
        return f'include "{target}" by its path from the root'
    if target_room is None:
        if quoted and "/" not in target and target.startswith(tuple("abcdefghijklmnopqrstuvwxyz")) and \
                os.path.exists(os.path.join(source_files.ROOT, os.path.dirname(path), target)):
            return f'include "{os.path.dirname(path)}/{target}" by its path from the root'
        for pattern, name, rooms in THIRD_PARTY:
            if re.match(pattern, target) and room not in rooms:
                return f"{room} must not use {name} (<{target}>); allowed in: {', '.join(rooms)}"
        return None
    if target_room == room or target_room in SEES[room]:
        return None
    return f"{room} must not include {target_room} ({target}); it sees: {', '.join(SEES[room]) or 'only itself'}"


def violations(root):
    for path in source_files.ours(root, source_files.CPP):
        room = room_of(path)
        if room is None:
            yield f"{path}:1: lies in no room that tools/check_layers.py knows"
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                include = INCLUDE.match(line)
                wrong = judge_include(path, room, include[1] == '"', include[2]) if include else None
                if wrong:
                    yield f"{path}:{number}: {wrong}"
                code = line.split("//")[0]
                if CLOCK.search(code) and room not in CLOCK_ROOMS:
                    yield f"{path}:{number}: {room} must not read a clock; time is a parameter"


def script_room_of(path):
    return max((room for room in SCRIPT_SEES if path.startswith(room + "/")), key=len, default=None)


def judge_import(path, room, target):
    """What is wrong with this import, or None."""
    if target.startswith("."):
        at = os.path.normpath(os.path.join(os.path.dirname(path), target))
        target_room = script_room_of(at) or os.path.dirname(at)
    else:
        target_room = next((name for name in ("@foreland/client", "@takram/three-atmosphere", "three", "maplibre-gl", "ws", "geographiclib-geodesic", "@tmcw/togeojson", "@xmldom/xmldom", "fflate", "proj4") if (target + "/").startswith(name + "/")), target.split(":")[0])
    if target_room == room or target_room in SCRIPT_SEES[room]:
        return None
    return f"{room} must not import {target_room} ({target}); it sees: {', '.join(SCRIPT_SEES[room]) or 'only itself'}"


def script_violations(root):
    for path in source_files.ours(root, (".ts",)):
        room = script_room_of(path)
        if room is None:
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                found = IMPORT.search(line)
                wrong = judge_import(path, room, found[1] or found[2]) if found else None
                if wrong:
                    yield f"{path}:{number}: {wrong}"
                if DOM.search(line.split("//")[0]) and not line.lstrip().startswith(("*", "/*")) and room not in DOM_ROOMS and path not in DOM_FILES:
                    yield f"{path}:{number}: {room} must not know a document"


PLANTED = [  # file, content, what must be said of it ("" for: nothing)
    ("base/a.h", "#pragma once\n", ""),
    ("proto/space/a.h", '#include "base/a.h"\n#include <glm/vec3.hpp>\n', ""),
    ("base/b.h", '#include "proto/space/a.h"\n', "base must not include proto/space"),
    ("client/a.cpp", '#include "server/net/a.h"\n', "client must not include server/net"),
    ("client/b.cpp", '#include "terrain/a.h"\n', "client must not include terrain"),
    ("client/mesh/patch/a.h", '#include "client/a.h"\n', "client/mesh/patch must not include client"),
    ("client/ground/a.h", '#include "client/viewer.h"\n', "client/ground must not include client"),
    ("proto/refine/memory/a.h", '#include "proto/refine/a.h"\n', "proto/refine/memory must not include proto/refine"),
    ("terrain/store/file/a.h", '#include "terrain/store/scene.h"\n', "terrain/store/file must not include terrain/store"),
    ("client/d.cpp", "#include <pugixml.hpp>\n", "must not use pugixml"),
    ("client/c.cpp", "#include <spdlog/spdlog.h>\n", "a library that WebAssembly lacks"),
    ("server/sched/c.cpp", "#include <chrono>\nc.wait_for(l, std::chrono::microseconds(1));\n", ""),
    ("base/c.h", "#include <chrono>\n", "also compiled to WebAssembly"),
    ("proto/codec/b.h", "#include <mutex>\n", "also compiled to WebAssembly"),
    ("server/view/a.h", '#include "server/section/a.h"\n', "server/view must not include server/section"),
    ("server/session/a.h", '#include "server/sched/a.h"\n#include "terrain/store/a.h"\n', ""),
    ("server/session/b.h", '#include "terrain/dem/a.h"\n', "server/session must not include terrain/dem"),
    ("server/section/b.cpp", "auto t = std::chrono::steady_clock::now();\n", "must not read a clock"),
    ("server/section/c.cpp", "// no steady_clock here\n", ""),
    ("server/net/b.cpp", "#include <boost/beast.hpp>\n#include <chrono>\n", ""),
    ("server/sched/b.cpp", "#include <boost/asio.hpp>\n", "must not use Boost"),
    ("terrain/store/b.cpp", "#include <gdal_priv.h>\n", "must not use GDAL"),
    ("terrain/pipeline/b.cpp", "  #  include <ImfInputFile.h>\n", "must not use OpenEXR"),
    ("terrain/dem/formats/b.cpp", "#include <gdal.h>\n#include <cpl_conv.h>\n#include <OpenEXR/ImfInputFile.h>\n", ""),
    ("terrain/dem/b.cpp", "#include <gdal.h>\n", "must not use GDAL"),
    ("terrain/dem/formats/c.cpp", '#include "terrain/dem/mosaic/a.h"\n', "terrain/dem/formats must not include terrain/dem/mosaic"),
    ("terrain/pipeline/d.cpp", '#include "terrain/dem/voids/a.h"\n', ""),
    ("terrain/pipeline/e.cpp", '#include "terrain/dem/open.h"\n', "terrain/pipeline must not include terrain/dem"),
    ("terrain/remesh/original/a.cpp", '#include "terrain/remesh/lattice/a.h"\n',
     "terrain/remesh/original must not include terrain/remesh/lattice"),
    ("terrain/remesh/a.cpp", '#include "terrain/remesh/paint/a.h"\n', "terrain/remesh must not include terrain/remesh/paint"),
    ("terrain/dem/c.cpp", "#include <GeographicLib/Geocentric.hpp>\n", "must not use GeographicLib"),
    ("terrain/pipeline/c.cpp", '#include "apps/a.h"\n', "must not include apps"),
    ("proto/codec/c.h", '#include "tests/support/a.h"\n', "must not include tests"),
    ("tests/terrain/b.cpp", '#include "sim/a.h"\n#include "tests/support/a.h"\n#include <gdal.h>\n#include <chrono>\n', ""),
    ("tests/terrain/c.cpp", '#include "lab/a.h"\n', "tests must not include lab"),
    ("examples/a.cpp", '#include "client/a.h"\n#include "server/session/a.h"\n#include "terrain/pipeline/a.h"\n', ""),
    ("examples/b.cpp", '#include "tests/support/a.h"\n', "examples must not include tests/support"),
    ("examples/c.cpp", "auto t = std::chrono::steady_clock::now();\n", "must not read a clock"),
    ("apps/c.cpp", '#include "lab/a.h"\n', "apps must not include lab"),
    ("oracle/c.cpp", '#include "server/section/a.h"\n', "oracle must not include server/section"),
    ("lab/b.cpp", '#include "client/a.h"\n#include "server/section/a.h"\n#include <chrono>\n', ""),
    ("tests/support/b.h", '#include "oracle/a.h"\n', ""),
    ("lab/d.cpp", "#include <draco/mesh/mesh.h>\n", "must not use Draco"),
    ("lab/wire/peers/a.cpp", '#include "lab/programs/a.h"\n#include <meshoptimizer.h>\n#include <zlib.h>\n', ""),
    ("lab/wire/peers/b.cpp", '#include "proto/space/a.h"\n', "must not include proto/space"),
    ("lab/c.cpp", '#include "tests/support/a.h"\n', "must not include tests"),
    ("proto/space/d.h", '#include "proto/../base/a.h"\n', "by its path from the root"),
    ("proto/section/e.h", '#include "proto/refine/a.h"\n', "proto/section must not include proto/refine"),
    ("proto/message/e.h", '#include "proto/codec/a.h"\n', ""),
    ("proto/e.h", "#pragma once\n", "lies in no room"),
    ("elsewhere/a.h", "#pragma once\n", "lies in no room"),
    ("client/js/src/core/a.ts", "import { A } from '../worker/b.js';\n", "client/js/src/core must not import client/js/src/worker"),
    ("client/js/src/a.ts", "import * as THREE from 'three';\n", "must not import three"),
    ("client/js/src/b.ts", "export { A } from './three/a.js';\n", "must not import client/js/src/three"),
    ("client/js/src/c.ts", "const title = document.title;\n", "must not know a document"),
    ("client/js/src/three/a.ts", "import * as THREE from 'three';\nimport { A } from '../core/b.js';\nwindow.open();\n", ""),
    ("client/js/src/three/b.ts", "import { A } from '../worker/b.js';\n", "must not import client/js/src/worker"),
    ("client/web/src/ui/a.ts", "import { A } from '../../../js/src/core/b';\n", "must not import client/js/src/core"),
    ("client/web/src/ui/b.ts", "import { A } from '@foreland/client/three';\nimport { B } from '../draw/b';\n", ""),
]


def self_test():
    failures = []
    with tempfile.TemporaryDirectory() as root:
        for path, content, _ in PLANTED:
            os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(content)
        found = [*violations(root), *script_violations(root)]
    for path, _, expected in PLANTED:
        about = [line for line in found if line.startswith(path + ":")]
        if bool(about) != bool(expected) or (expected and expected not in about[0]):
            failures.append(f"{path}: expected '{expected}', got {about}")
    for room, seen in SEES.items():
        for other in seen:
            if room in SEES[other]:
                failures.append(f"{room} and {other} see each other")
    return failures


def main():
    if sys.argv[1:] not in ([], ["--self-test"]):
        print(__doc__, file=sys.stderr)
        return 2
    found = self_test() if sys.argv[1:] else [*violations(source_files.ROOT), *script_violations(source_files.ROOT)]
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
