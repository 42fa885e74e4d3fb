#!/usr/bin/env python3
"""Flies over a server's terrain without drawing it, and reads heights: of the ground below the eye as it is held, and exactly.

    examples/python/fly.py ws://127.0.0.1:8080 [--seconds 5] [--library libforeland_client.so.0]

Needs nothing but Python: ctypes calls the C interface, whose structs are those of foreland.h.
"""

import argparse
import ctypes
import math
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int32, c_uint32, c_uint64, c_void_p, sizeof

OK, NOTHING = 0, 1
OFF = 2
SCENE, STALL, REFUSED, FAILED, HEIGHTS = 1, 3, 5, 6, 8


class Options(Structure):
    _fields_ = [("size", c_uint32), ("strategy", c_uint32), ("predictor", c_uint32), ("blend", c_uint32), ("tolerance_px", c_double),
                ("keyframe_ms", c_double), ("longest_keyframe_ms", c_double), ("occlusion", c_uint32), ("relief", c_uint32),
                ("meshes", c_uint32), ("memory_bytes", c_uint32), ("tile_bytes", c_uint32), ("reserved", c_uint32),
                ("token", c_char_p), ("ca_file", c_char_p)]


class Pose(Structure):
    _fields_ = [("eye", c_double * 3), ("orientation", c_double * 4)]


class MapPoint(Structure):
    _fields_ = [("x", c_double), ("y", c_double), ("height", c_double)]


class Place(Structure):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("at", MapPoint), ("ground", c_double), ("slope", c_double),
                ("up", c_double * 3), ("lattice", c_double * 2)]


class Scene(Structure):  # the rest of it is not needed here: the library writes as much as `size` says
    _fields_ = [("size", c_uint32), ("is_geographic", c_uint32), ("id", c_uint64), ("title", c_char_p), ("crs", c_char_p),
                ("low", c_double * 3), ("high", c_double * 3), ("lowest", c_double), ("highest", c_double)]


class Frame(Structure):
    _fields_ = [("size", c_uint32), ("version", c_uint32), ("weight", c_double), ("pose", Pose), ("guaranteed_px", c_double)]


class Event(Structure):
    _fields_ = [("size", c_uint32), ("kind", c_uint32), ("question", c_uint64), ("value", c_double), ("message", c_char_p),
                ("heights", POINTER(c_double)), ("sights", c_void_p), ("viewshed", c_void_p), ("count", c_uint32), ("reserved", c_uint32)]


def sized(struct, **fields):
    return struct(size=sizeof(struct), **fields)


class Terrain:
    def __init__(self, library, server, **options):
        self.library = ctypes.CDLL(library)
        self.library.foreland_now.restype = c_double
        self.library.foreland_last_error.restype = c_char_p
        self.library.foreland_close.argtypes, self.library.foreland_close.restype = [c_void_p], None
        self.handle = c_void_p()
        self.call("foreland_open", server.encode(), byref(sized(Options, **options)), byref(self.handle), handle=False)

    def call(self, name, *arguments, handle=True):
        """Whether there was what was asked for; raises the library's own words."""
        status = getattr(self.library, name)(*((self.handle,) if handle else ()), *arguments)
        if status not in (OK, NOTHING):
            raise RuntimeError(self.library.foreland_last_error().decode())
        return status == OK

    def wait_for(self, kind, seconds=30):
        """The next event of a kind. Says why there is no connection, and gives up if there will be none."""
        until = self.library.foreland_now() + 1000 * seconds
        while self.library.foreland_now() < until:
            self.call("foreland_wait", c_double(100))
            event = sized(Event)
            while self.call("foreland_next_event", byref(event)):
                if event.kind == kind:
                    return event
                if event.kind in (STALL, REFUSED, FAILED):
                    print(event.message.decode())
                if event.kind in (REFUSED, FAILED):
                    raise RuntimeError("the session has ended")
        raise TimeoutError(f"no answer in {seconds} s")

    def pass_events(self):
        while self.call("foreland_next_event", byref(sized(Event))):
            pass

    def scene(self):
        scene = sized(Scene)
        self.call("foreland_get_scene", byref(scene))
        return scene

    def frame(self, eye):
        frame = sized(Frame)
        self.call("foreland_frame", c_double(self.library.foreland_now()), byref(Pose((c_double * 3)(*eye), (c_double * 4)(0, 0, 0, 1))), byref(frame))
        return frame

    def place(self, point):
        place = sized(Place)
        self.call("foreland_to_geodetic", (c_double * 3)(*point), byref(place))
        return place

    def heights(self, places):
        question = c_uint64()
        self.call("foreland_heights", (MapPoint * len(places))(*places), c_uint32(len(places)), byref(question))
        event = self.wait_for(HEIGHTS)
        return event.heights[:event.count]

    def close(self):
        self.library.foreland_close(self.handle)


def main():
    parser = argparse.ArgumentParser(description="Flies over a server's terrain and reads heights.")
    parser.add_argument("server", help="such as ws://127.0.0.1:8080")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--library", default="libforeland_client.so.0")
    given = parser.parse_args()

    terrain = Terrain(given.library, given.server, meshes=OFF)
    terrain.wait_for(SCENE)
    scene = terrain.scene()
    print(f"{scene.title.decode()}: {scene.lowest:.0f} to {scene.highest:.0f} m")

    # From west to east through the middle, 200 m above the highest ground.
    begin, seen = terrain.library.foreland_now(), []
    while (share := (terrain.library.foreland_now() - begin) / (1000 * given.seconds)) < 1:
        eye = [scene.low[0] + (0.1 + 0.8 * share) * (scene.high[0] - scene.low[0]), 0.5 * (scene.low[1] + scene.high[1]), scene.high[2] + 200]
        frame, place = terrain.frame(eye), terrain.place(eye)
        if frame.version > 0 and not math.isnan(place.ground):
            seen.append((MapPoint(place.at.x, place.at.y, 0), place.ground))
        terrain.pass_events()
        terrain.call("foreland_wait", c_double(16))

    chosen = seen[::max(1, len(seen) // 20)]
    exact = terrain.heights([place for place, _ in chosen])
    for (place, held), height in zip(chosen, exact):
        print(f"{place.x:12.2f} {place.y:12.2f}  {held:8.2f} m held  {height:8.2f} m exactly")
    terrain.close()
    if not chosen:
        raise SystemExit("no ground was seen in that time: fly for longer")
    print(f"{len(seen)} frames over ground; at most {max(abs(held - height) for (_, held), height in zip(chosen, exact)):.2f} m from the exact heights")


if __name__ == "__main__":
    main()
