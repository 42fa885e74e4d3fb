#!/usr/bin/env python3
"""One large scene in a store, servers with small caches behind deploy/haproxy-fleet.cfg, and viewers who fly about all of it: led by the scene alone, and by the area that they are in.

    lab/trials/areas.py SCENE.fls [--servers 4] [--viewers 128] [--places 12] [--cache-mib 32 256] [--seconds 30] [--out FILE.json]

Each pair of viewers (`foreland fly --viewers 2`) flies around a place of its own, which is at random about one of --places that people like to look at; the
scene must be of geographic data. They come and fly for a while; then all connections are cut, for the proxy is started anew, and they fly on; then the servers are replaced in
turn, as for a new version, and later all are killed and started anew, and have empty caches. Each time viewers connect again, and say then which area they are
in.

    scene  the proxy looks at the scene's path alone
    area   as it is shipped: the path, and the area, which viewers say from the second connection on
    known  the same, and viewers say it on the first connection, too, as those of a link do

Of each size of the caches, way and part (`come`, `cut`, `on`, `replaced`, `lost`): what was fetched from the store, how many chunks were evicted, which part of the viewers
waited for what was not there, and what tolerance was stated. Prints JSON; exits 1 if a viewer was lost.
Programs are those of FORELAND_BIN (default build/release/bin).
"""

import argparse
import contextlib
import json
import math
import random
import re
import signal
import time
from pathlib import Path

from fleet import configuration, is_led_to, lay
from running import Program, finish, foreland, free_port, metrics, nginx, port_of, say, scratch, until

GROUP = 2  # viewers of a process, the least that need no meshes
WAYS = ("scene", "area", "known")
PARTS = ("come", "cut", "on", "replaced", "lost")
AREA = 2048  # client/area.h
ABOUT = 150  # samples
RADIUS_M, SPEED_MPS, HEIGHT_M = 2500, 80, 400
EARTH_M = 6371000
SEEN_S = 2  # until the proxy has seen that a server is new
COUNTS = ("fetched_bytes", "fetched_chunks", "evicted_chunks")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--servers", type=int, default=4)
    parser.add_argument("--viewers", type=int, default=128)
    parser.add_argument("--places", type=int, default=12, help="that people like to look at")
    parser.add_argument("--over", type=float, default=20, help="seconds in which they come")
    parser.add_argument("--seconds", type=int, default=30, help="of each part")
    parser.add_argument("--cache-mib", type=int, nargs="+", default=[32, 256])
    parser.add_argument("--viewport", default="640x360")
    parser.add_argument("--tau", default="1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--out")
    return parser.parse_args()


class Lattice:
    """Where a scene's samples lie, as `foreland info` tells."""

    def __init__(self, scene):
        with Program(foreland("info"), scene) as info:
            text = info.result()[1]
        number = r"(-?[\d.]+)"
        self.columns, self.rows = (int(n) for n in re.search(r"samples +(\d+) x (\d+)", text).groups())
        latitude, longitude, latitude_step, longitude_step = re.search(rf"lattice +from latitude {number}, longitude {number} degrees in steps of {number}, {number}", text).groups()
        self.latitude, self.longitude = float(latitude), float(longitude)
        self.steps = float(latitude_step), float(longitude_step)

    def geodetic(self, x, y):
        return self.latitude + y * self.steps[0], self.longitude + x * self.steps[1]

    def area(self, x, y):
        return int(y // AREA) * -(-(self.columns - 1) // AREA) + int(x // AREA)


def places(lattice, count, pairs, seed):
    """Where pairs of viewers fly, who are at random about places of which there are `count`; the places lie anywhere."""
    chance, margin = random.Random(seed), 0.07
    anywhere = lambda samples: (margin + (1 - 2 * margin) * chance.random()) * (samples - 1)
    middles = [(anywhere(lattice.columns), anywhere(lattice.rows)) for _ in range(count)]
    about = lambda middle: tuple(at + chance.uniform(-ABOUT, ABOUT) for at in middle)
    return [about(chance.choice(middles)) for _ in range(pairs)]


def write_track(path, lattice, place, seconds):
    """A circle about a place, for so long."""
    latitude, longitude = lattice.geodetic(*place)
    lines = []
    for s in range(0, math.ceil(seconds) + 4, 2):
        angle = s * SPEED_MPS / RADIUS_M
        north, east = RADIUS_M * math.sin(angle), RADIUS_M * math.cos(angle)
        lat = latitude + math.degrees(north / EARTH_M)
        lon = longitude + math.degrees(east / EARTH_M / math.cos(math.radians(latitude)))
        lines.append(f'<trkpt lat="{lat:.7f}" lon="{lon:.7f}"><ele>0</ele><time>2026-11-30T{s // 3600:02}:{s // 60 % 60:02}:{s % 60:02}Z</time></trkpt>')
    path.write_text('<gpx version="1.1"><trk><trkseg>' + "".join(lines) + "</trkseg></trk></gpx>")


class Fleet:
    """Servers, which can be replaced, and what they counted, those that have ended included."""

    def __init__(self, stack, options, cache_mib, scene):
        self._stack, self._options, self._cache_mib, self._scene = stack, options, cache_mib, scene
        self._ended = dict.fromkeys(COUNTS, 0)
        self._programs = []
        self.servers = []
        for _ in range(options.servers):
            program, server = self._start(0, free_port())
            self._programs.append(program)
            self.servers.append(server)

    def _start(self, port, agent):
        program = self._stack.enter_context(Program(
            foreland("serve"), self._scene, "--listen", f"127.0.0.1:{port}", "--agent-listen", f"127.0.0.1:{agent}", "--trusted-proxy", "127.0.0.1",
            "--store-cache-mib", self._cache_mib, "--threads", "1", "--log-level", "off"))
        if not (line := program.line()):
            raise RuntimeError("a server does not start")
        return program, (port_of(line), agent)

    def _end(self, i, number):
        last = metrics(self.servers[i][0])
        for key in COUNTS:
            self._ended[key] += last[f"store_{key}_total"]
        self._programs[i].kill(number)
        self._programs[i].result()

    def _begin(self, i):
        self._programs[i], _ = self._start(*self.servers[i])

    def replace_in_turn(self):
        for i in range(len(self.servers)):
            self._end(i, signal.SIGTERM)
            self._begin(i)
            time.sleep(SEEN_S)

    def lose_all(self):
        for i in range(len(self.servers)):
            self._end(i, signal.SIGKILL)
        for i in range(len(self.servers)):
            self._begin(i)

    def counts(self):
        seen = [metrics(port) for port, _ in self.servers]
        return {key: int(self._ended[key] + sum(one[f"store_{key}_total"] for one in seen)) for key in COUNTS}, seen


def watch(fleet, seconds):
    """What happens in some seconds, and what was counted until then, all in all."""
    end, waiting, flying, stated = time.monotonic() + seconds, 0, 0, []
    while time.monotonic() < end:
        time.sleep(0.5)
        for one in fleet.counts()[1]:
            waiting += one["store_lacking"]
            flying += one["flying"]
            stated += [one["tolerance_px"]] * int(one["flying"])
    counts, seen = fleet.counts()
    stated = sorted(stated) or [0]
    return {**counts, "waiting_share": round(waiting / max(flying, 1), 3),
            "stated_px_median": round(stated[len(stated) // 2], 2), "stated_px_p90": round(stated[len(stated) * 9 // 10], 2),
            "viewers_of_servers": [int(one["flying"]) for one in seen], "cache_bytes": [int(one["store_cache_bytes"]) for one in seen]}


def fly(options, way, cache_mib, folder, store, lattice):
    with contextlib.ExitStack() as stack:
        fleet = Fleet(stack, options, cache_mib, f"http://127.0.0.1:{store}/{options.scene.name}")
        door, name = free_port(), options.scene.stem
        text = configuration("hash", fleet.servers)
        text = re.sub("use_backend scenes if .*", "use_backend scenes if { path_end /fly }", text)  # all are led by hashing
        if way == "scene":
            text = text.replace("balance hash var(txn.ground)", "balance hash path")
        (folder / "haproxy.cfg").write_text(text)
        start_proxy = lambda: stack.enter_context(Program("/usr/sbin/haproxy", "-q", "-f", folder / "haproxy.cfg", env={"FORELAND_PUBLIC": f"127.0.0.1:{door}"}))
        proxy = start_proxy()
        until(lambda: is_led_to(f"http://127.0.0.1:{door}/fly"), f"{name} behind HAProxy")

        flights, groups = [], options.viewers // GROUP
        all_s = options.over + len(options.parts) * options.seconds + 20 * options.servers
        begin = time.monotonic()
        for i, place in enumerate(places(lattice, options.places, groups, options.seed)):
            time.sleep(max(0, begin + options.over * i / groups - time.monotonic()))
            left = all_s - (time.monotonic() - begin)
            track = folder / f"{i}.gpx"
            write_track(track, lattice, place, left)
            address = f"ws://127.0.0.1:{door}/fly" + (f"?area={lattice.area(*place)}" if way == "known" else "")
            flights.append(stack.enter_context(Program(
                foreland("fly"), address, "--viewers", GROUP, "--track", track, "--agl", HEIGHT_M, "--seconds", round(left), "--tau", options.tau,
                "--viewport", options.viewport, "--json")))
        def cut():
            proxy.kill()
            start_proxy()

        events, found, before = {"come": lambda: None, "cut": cut, "on": lambda: None, "replaced": fleet.replace_in_turn, "lost": fleet.lose_all}, {}, dict.fromkeys(COUNTS, 0)
        for part in options.parts:
            events[part]()
            found[part] = watch(fleet, options.seconds)
            for key in COUNTS:
                before[key], found[part][key] = found[part][key], found[part][key] - before[key]
        for flight in flights:
            flight.kill(signal.SIGINT)
        reports = [json.loads(output) if (output := flight.result()[1]).strip() else {"error": "no report"} for flight in flights]
    total = lambda key: sum(report.get(key, 0) for report in reports)
    return {"errors": sorted({error for report in reports if (error := report.get("error", "interrupted")) != "interrupted"}), "resumed": total("resumed"),
            "started_afresh": total("started_afresh"), "late_keyframes": total("late_keyframes"), "keyframes": total("keyframes"), **found}


def main():
    options = parse()
    lattice = Lattice(options.scene)
    report = {"servers": options.servers, "viewers": options.viewers, "scene_bytes": options.scene.stat().st_size, "seed": options.seed, "caches": {}, "broken": []}
    with scratch() as folder:
        lay([options.scene], folder)
        store = free_port()
        with nginx(folder, store):
            for cache_mib in options.cache_mib:
                found = report["caches"][f"{cache_mib} MiB"] = {}
                for way in options.ways:
                    say(f"{cache_mib} MiB, {way}")
                    found[way] = fly(options, way, cache_mib, folder, store, lattice)
                    report["broken"] += [f"{cache_mib} MiB, {way}: {error}" for error in found[way]["errors"]]
                    if options.out:
                        Path(options.out).write_text(json.dumps(report, indent=1) + "\n")
    finish(report, options.out)


if __name__ == "__main__":
    main()
