#!/usr/bin/env python3
"""Servers of several scenes in a store behind deploy/haproxy-fleet.cfg, with viewers that come over a minute: by hashing, and by the fewest connections.

    lab/trials/fleet.py SCENE.fls... [--servers 4] [--viewers 200] [--over 60] [--seconds 60] [--cache-mib 16] [--out FILE.json]

Viewers are light ones (`foreland fly --viewers`), each flies over one scene. For each way: bytes that the servers fetch of the scenes, and how evenly
processors are used: each server's processor time in five seconds, the largest over the mean, from when all have come until the first lands.
Prints JSON; exits 1 if a viewer does not land. Programs are those of FORELAND_BIN (default build/release/bin).
"""

import argparse
import contextlib
import json
import os
import re
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

from running import ROOT, Program, finish, foreland, free_port, metrics, nginx, port_of, say, scratch, until

GROUP = 5  # viewers of a process
WINDOW_S = 5


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--servers", type=int, default=4)
    parser.add_argument("--viewers", type=int, default=200)
    parser.add_argument("--over", type=float, default=60, help="seconds in which they come")
    parser.add_argument("--seconds", type=int, default=60, help="that each flies when all have come")
    parser.add_argument("--cache-mib", type=int, default=16, help="of each scene at each server")
    parser.add_argument("--tau", default="2")
    parser.add_argument("--out")
    return parser.parse_args()


def lay(scenes, folder):
    for scene in scenes:
        os.symlink(scene.resolve(), folder / scene.name)
        with Program(foreland("sums"), scene, "-o", folder / f"{scene.name}.sums") as sums:
            if sums.result()[0] != 0:
                sys.exit(f"foreland sums {scene} does not do")


def configuration(way, servers):
    """The shipped one, with servers by their addresses; leastconn for scenes, too, if that is the way."""
    text = (ROOT / "deploy/haproxy-fleet.cfg").read_text()
    lines = "\n  ".join(f"server s{i} 127.0.0.1:{port} agent-port {agent}" for i, (port, agent) in enumerate(servers))
    text = re.sub(r"server-template .*", lines, text)
    if way == "leastconn":
        text = re.sub(r"balance hash path\n  hash-type consistent\n  hash-balance-factor \d+", "balance leastconn", text)
    return text


def is_led_to(address):
    """Whether a server answers a viewer of an address: with 426, for this is none."""
    try:
        urllib.request.urlopen(address, timeout=5).close()
    except urllib.error.HTTPError as error:
        return error.code == 426
    except OSError:
        pass
    return False


def used(ports):
    return [metrics(port)["process_cpu_seconds_total"] for port in ports]


def fly(options, way, folder, store):
    with contextlib.ExitStack() as stack:
        start = lambda *words, **more: stack.enter_context(Program(*words, **more))
        servers = []
        for _ in range(options.servers):
            agent = free_port()
            server = start(foreland("serve"), *(f"http://127.0.0.1:{store}/{scene.name}" for scene in options.scenes), "--listen", "127.0.0.1:0",
                           "--agent-listen", f"127.0.0.1:{agent}", "--store-cache-mib", options.cache_mib, "--threads", "1", "--log-level", "off")
            servers.append((port_of(server.line()), agent))
        ports, door = [port for port, _ in servers], free_port()
        (folder / f"{way}.cfg").write_text(configuration(way, servers))
        start("/usr/sbin/haproxy", "-q", "-f", folder / f"{way}.cfg", env={"FORELAND_PUBLIC": f"127.0.0.1:{door}"})
        for scene in options.scenes:
            until(lambda: is_led_to(f"http://127.0.0.1:{door}/{scene.stem}/fly"), f"{scene.stem} behind HAProxy")

        groups, flights = max(1, options.viewers // GROUP), []
        begin = time.monotonic()
        for i in range(groups):
            time.sleep(max(0, begin + options.over * i / groups - time.monotonic()))
            scene = options.scenes[i % len(options.scenes)]
            left = options.seconds + options.over - (time.monotonic() - begin)
            flights.append(start(foreland("fly"), f"ws://127.0.0.1:{door}/{scene.stem}/", "--viewers", GROUP, "--tour", ("survey", "canyon")[i // len(options.scenes) % 2],
                                 "--seconds", round(left), "--tau", options.tau, "--viewport", "320x180", "--json"))
        until(lambda: sum(metrics(port)["flying"] for port in ports) >= 0.95 * groups * GROUP, "all viewers")
        came_s, windows, before = time.monotonic() - begin, [], used(ports)
        while time.monotonic() < begin + options.over + options.seconds - WINDOW_S and all(flight.is_running() for flight in flights):
            time.sleep(WINDOW_S)
            after = used(ports)
            gained = [b - a for a, b in zip(before, after)]
            windows.append(max(gained) * len(gained) / max(sum(gained), 1e-9))
            before = after
        counts = [metrics(port) for port in ports]
        reports = [json.loads(output) if (output := flight.result()[1]).strip() else {} for flight in flights]
        last = [metrics(port) for port in ports]
    total = lambda key: sum(report.get(key, 0) for report in reports)
    return {"viewers": groups * GROUP, "landed": total("landed"), "reconnected": total("resumed") + total("started_afresh"), "keyframes": total("keyframes"),
            "late_keyframes": total("late_keyframes"), "longest_gap_p99_ms": max(report.get("longest_gap_p99_ms", 0) for report in reports),
            "came_s": round(came_s, 1), "viewers_of_servers": [int(count["flying"]) for count in counts], "handed_over": int(sum(count["handed_over_total"] for count in last)),
            "use_largest_over_mean": [round(window, 2) for window in windows], "fetched_bytes": int(sum(count["store_fetched_bytes_total"] for count in last)),
            "evicted_chunks": int(sum(count["store_evicted_chunks_total"] for count in last)), "waiting": [int(count["store_lacking"]) for count in counts]}


def main():
    options = parse()
    report = {"servers": options.servers, "scenes": len(options.scenes), "cache_mib": options.cache_mib, "over_s": options.over, "broken": []}
    with scratch() as folder:
        lay(options.scenes, folder)
        store = free_port()
        with nginx(folder, store):
            for way in ("hash", "leastconn"):
                say(way)
                report[way] = fly(options, way, folder, store)
                if report[way]["landed"] != report[way]["viewers"]:
                    report["broken"].append(f"{way}: {report[way]['landed']} of {report[way]['viewers']} viewers landed")
    finish(report, options.out)


if __name__ == "__main__":
    main()
