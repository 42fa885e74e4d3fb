#!/usr/bin/env python3
"""Servers of several scenes in a store behind deploy/haproxy-fleet.cfg, with viewers that come over a minute: by hashing, and by the fewest connections.

    lab/trials/fleet.py SCENE.fls... [--servers 4] [--viewers 200] [--share 0.2] [--over 60] [--seconds 60] [--cache-mib 16] [--out FILE.json]

Viewers are light ones (`foreland fly --viewers`), each flies over one scene. --share is the part of a processor that each server may take (as root), so
that a small machine is a fleet of slow ones: when viewers have come and flown for a while, the first server gets half of it.

For each way: how many of the chunks that viewers begin to need were there without being fetched for them, bytes that the servers fetch of the scenes,
and how evenly processors are used: of each server's processor time in some seconds, as a part of what it may take, the largest over the mean. Prints
JSON; exits 1 if a viewer does not land, or another law of the issue does not hold: the use is uneven (1.2) for more than 30 s after all have come, or
after the first server got slow; or 1 in 100 viewers had no keyframe for over a second.
Programs are those of FORELAND_BIN (default build/release/bin).
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

from running import ROOT, Program, Share, finish, foreland, free_port, metrics, nginx, port_of, say, scratch, until

GROUP = 5  # viewers of a process
STEP_S, WINDOW_S = 5, 10
WAYS = ("hash", "leastconn")
UNEVEN, PATIENCE_S, GAP_MS = 1.2, 30, 1000


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--servers", type=int, default=4)
    parser.add_argument("--viewers", type=int, default=200)
    parser.add_argument("--over", type=float, default=60, help="seconds in which they come")
    parser.add_argument("--seconds", type=int, default=60, help="that each flies when all have come, and again when a server is slow")
    parser.add_argument("--share", type=float, default=0, help="of a processor for each server; 0: no limit, and none gets slow")
    parser.add_argument("--cache-mib", type=int, default=16, help="of each scene at each server")
    parser.add_argument("--tau", default="2")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=WAYS)
    parser.add_argument("--out")
    return parser.parse_args()


def lay(scenes, folder):
    for scene in scenes:
        os.symlink(scene.resolve(), folder / scene.name)
        with Program(foreland("sums"), scene, "-o", folder / f"{scene.name}.sums") as sums:
            if sums.result()[0] != 0:
                sys.exit(f"foreland sums {scene} does not do")


def configuration(way, servers):
    """The shipped one, with servers by their addresses, and connections for which this machine's open files suffice; leastconn for scenes, too, if that is the way."""
    text = re.sub(r"maxconn \d+", "maxconn 2000", (ROOT / "deploy/haproxy-fleet.cfg").read_text())
    lines = "\n  ".join(f"server s{i} 127.0.0.1:{port} agent-port {agent}" for i, (port, agent) in enumerate(servers))
    text = re.sub(r"server-template .*", lines, text)
    if way == "leastconn":
        text = re.sub(r"balance hash var\(txn.ground\)\n  hash-type consistent\n  hash-balance-factor \d+", "balance leastconn", text)
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


class Use:
    """Of servers' processors, from when it is made. `speeds` are the parts of a processor that they may take."""

    def __init__(self, ports, speeds):
        self._ports, self._speeds, self._begin, self._seen = ports, speeds, time.monotonic(), [self._now(ports)]

    @staticmethod
    def _now(ports):
        return time.monotonic(), [metrics(port)["process_cpu_seconds_total"] for port in ports]

    def watch(self, seconds, flights):
        """Largest over mean, and how long it took until that was even and stayed so."""
        ratios, means, even_since = [], [], 0
        while time.monotonic() < self._begin + seconds and all(flight.is_running() for flight in flights):
            time.sleep(STEP_S)
            self._seen.append(self._now(self._ports))
            (begin, before), (at, now) = self._seen[-1 - min(len(self._seen) - 1, WINDOW_S // STEP_S)], self._seen[-1]
            used = [(b - a) / (at - begin) / speed for a, b, speed in zip(before, now, self._speeds)]
            means.append(round(sum(used) / len(used), 2))
            ratios.append(round(max(used) * len(used) / max(sum(used), 1e-9), 2))
            if ratios[-1] >= UNEVEN:
                even_since = at - self._begin
        return {"use_mean": means, "use_largest_over_mean": ratios, "even_after_s": round(even_since, 1),
                "viewers_of_servers": [int(metrics(port)["flying"]) for port in self._ports], "load": [round(metrics(port)["pool_load"], 2) for port in self._ports]}


def p99_of_gaps(reports):
    """Of the viewers' longest gaps: that which 1 in 100 viewers exceeds, at most."""
    gaps = sorted(gap for report in reports for gap in report.get("longest_gaps_ms", [1e9] * GROUP))
    return round(gaps[min(len(gaps) - 1, -(-99 * len(gaps) // 100) - 1)], 1)


def fly(options, way, folder, store):
    with contextlib.ExitStack() as stack:
        start = lambda *words, **more: stack.enter_context(Program(*words, **more))
        servers, shares = [], []
        for i in range(options.servers):
            agent = free_port()
            if options.share:
                shares.append(stack.enter_context(Share(f"{way}-{i}")))
            server = start(foreland("serve"), *(f"http://127.0.0.1:{store}/{scene.name}" for scene in options.scenes), "--listen", "127.0.0.1:0",
                           "--agent-listen", f"127.0.0.1:{agent}", "--trusted-proxy", "127.0.0.1", "--store-cache-mib", options.cache_mib, "--threads", "1", "--log-level", "off")
            servers.append((port_of(server.line()), agent))
            if options.share:
                shares[-1].set(options.share)
                shares[-1].add(server)
        ports, door = [port for port, _ in servers], free_port()
        (folder / f"{way}.cfg").write_text(configuration(way, servers))
        start("/usr/sbin/haproxy", "-q", "-f", folder / f"{way}.cfg", env={"FORELAND_PUBLIC": f"127.0.0.1:{door}"})
        for scene in options.scenes:
            until(lambda: is_led_to(f"http://127.0.0.1:{door}/{scene.stem}/fly"), f"{scene.stem} behind HAProxy")

        groups, flights = max(1, options.viewers // GROUP), []
        all_s = options.over + options.seconds * (2 if options.share else 1)
        begin = time.monotonic()
        for i in range(groups):
            time.sleep(max(0, begin + options.over * i / groups - time.monotonic()))
            scene = options.scenes[i % len(options.scenes)]
            left = all_s - (time.monotonic() - begin)
            flights.append(start(foreland("fly"), f"ws://127.0.0.1:{door}/{scene.stem}/", "--viewers", GROUP, "--tour", ("survey", "canyon")[i // len(options.scenes) % 2],
                                 "--seconds", round(left), "--tau", options.tau, "--viewport", "320x180", "--json"))
        until(lambda: sum(metrics(port)["flying"] for port in ports) >= 0.95 * groups * GROUP, "all viewers")
        came_s, speeds = time.monotonic() - begin, [options.share or 1] * len(ports)
        found = {"come": Use(ports, speeds).watch(options.seconds - (came_s - options.over) - STEP_S, flights)}
        if options.share:
            shares[0].set(options.share / 2)
            speeds[0] /= 2
            found["slowed"] = Use(ports, speeds).watch(options.seconds - STEP_S, flights)
        reports = [json.loads(output) if (output := flight.result()[1]).strip() else {} for flight in flights]
        last = [metrics(port) for port in ports]
    total = lambda key: sum(report.get(key, 0) for report in reports)
    counted = lambda key: int(sum(count[key] for count in last))
    uses, chunks = counted("store_uses_total"), counted("store_fetched_chunks_total")
    return {"viewers": groups * GROUP, "landed": total("landed"),
            "errors": sorted({report["error"] for report in reports if "error" in report}), "reconnected": total("resumed") + total("started_afresh"),
            "keyframes": total("keyframes"),
            "late_keyframes": total("late_keyframes"), "longest_gap_p99_ms": p99_of_gaps(reports), "longest_gap_ms": max(report.get("longest_gap_ms", 0) for report in reports), "longest_resume_ms": round(max(report.get("longest_resume_ms", 0) for report in reports), 1), "came_s": round(came_s, 1), "handed_over": counted("handed_over_total"),
            **found, "cache_hit_rate": round(1 - chunks / max(uses, 1), 6), "fetched_bytes": counted("store_fetched_bytes_total"), "evicted_chunks": counted("store_evicted_chunks_total")}


def broken_by(report, way):
    if report["landed"] != report["viewers"]:
        yield f"{way}: {report['landed']} of {report['viewers']} viewers landed"
    if way != "hash":
        return  # to compare with
    for phase in ("come", "slowed"):
        if report.get(phase, {}).get("even_after_s", 0) > PATIENCE_S:
            yield f"{way}, {phase}: the use was uneven for {report[phase]['even_after_s']} s"
    if report["longest_gap_p99_ms"] > GAP_MS:
        yield f"{way}: {report['longest_gap_p99_ms']} ms without a keyframe"


def main():
    options = parse()
    report = {"servers": options.servers, "scenes": len(options.scenes), "cache_mib": options.cache_mib, "over_s": options.over, "share": options.share, "broken": []}
    with scratch() as folder:
        lay(options.scenes, folder)
        store = free_port()
        with nginx(folder, store):
            for way in options.ways:
                say(way)
                report[way] = fly(options, way, folder, store)
                report["broken"] += broken_by(report[way], way)
    finish(report, options.out)


if __name__ == "__main__":
    main()
