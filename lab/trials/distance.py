#!/usr/bin/env python3
"""Viewers on tours over a scene in a store, with a cache that is far smaller than the scene, while the store is well, slow, dead or lies.

    lab/trials/distance.py SCENE.fls [--cache-mib 200] [--viewers 10] [--seconds 40] [--trials NAME...] [--out FILE.json]

A trial is a server of its own, with an empty cache, that reads from nginx through `foreland link`, or from s3rver (npm; --s3rver), or from a folder
that rclone mounts (--rclone; needs FUSE). Each viewer is a `foreland fly`. Their recordings are judged when all have landed, against the scene at
full resolution (`foreland replay --truth`). Prints JSON; exits 1 if a viewer was disconnected, or a frame was off by more than it stated, had
a crack or a hole, or if a trial did not do to the store what it is named after. Frames right after a jump show the section for another place, and
state nothing (`frames_stating_nothing`). Programs are those of FORELAND_BIN (default build/release/bin).

    near      10 ms away: what viewers fetch
    slow      100 ms and 1 Mbit/s for all together
    killed    as near; nginx gets SIGKILL after a third of the flight, and is back after two thirds
    garbage   as near; in the second third another answers in its place, with anything but what was asked for
    jumps     as near; one viewer jumps, and again when all of that has been fetched
    s3        from s3rver
    rclone    `rclone mount`, which waits for what is missing
    local     the file itself: what this machine makes of so many viewers
"""

import argparse
import contextlib
import json
import os
import shutil
import signal
import sys
import threading
import time
from pathlib import Path

from running import Program, answers, finish, foreland, free_port, metrics, nginx, port_of, say, scratch, until

TOURS = ("survey", "canyon", "orbit", "jumps", "spin")
NEAR = ("--round-trip", "10")
SLOW = ("--shared", "--round-trip", "100", "--up", "1", "--down", "1")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--cache-mib", type=int, default=200)
    parser.add_argument("--viewers", type=int, default=10)
    parser.add_argument("--seconds", type=int, default=40)
    parser.add_argument("--viewport", default="640x360")
    parser.add_argument("--tau", default="1")
    parser.add_argument("--judge-frames", type=int, default=20, help="of each flight")
    parser.add_argument("--judge-flights", type=int, default=1000, help="of each trial; one takes memory for all of the scene at full resolution")
    parser.add_argument("--trials", nargs="+", choices=TRIALS, default=list(TRIALS))
    parser.add_argument("--s3rver", default=shutil.which("s3rver"))
    parser.add_argument("--rclone", default=shutil.which("rclone"))
    parser.add_argument("--keep", help="a folder for recordings and logs")
    parser.add_argument("--out")
    return parser.parse_args()


class Trial:
    """A store, a server that reads from it, and viewers. `broken` gets what should not have been."""

    def __init__(self, name, options, folder):
        self.name, self.options, self.folder = name, options, folder / name
        self.folder.mkdir(exist_ok=True)
        self.stack, self.broken, self.report, self.to_judge = contextlib.ExitStack(), [], {}, []
        self.store_port = free_port()

    def law(self, holds, text):
        if not holds:
            self.broken.append(f"{self.name}: {text}")

    def start(self, *words, **more):
        return self.stack.enter_context(Program(*words, **more))

    def start_nginx(self):
        return self.stack.enter_context(nginx(self.folder, self.store_port))

    def start_link(self, link):
        return port_of(self.start(foreland("link"), "--listen", "127.0.0.1:0", "--to", f"127.0.0.1:{self.store_port}", *link).line())

    def serve(self, address, env=None):
        """Starts the server; `address` is the scene's."""
        self.server = self.start(foreland("serve"), address, "--listen", "127.0.0.1:0", "--store-cache-mib", self.options.cache_mib,
                                 "--store-cache-dir", self.folder, "--log-level", "off", env=env)
        line = self.server.line()
        if ":" not in line:
            raise RuntimeError(f"the server of {address} does not start")
        self.port = port_of(line)

    def fly(self, tours, label, events=(), seconds=None):
        """Flies all tours at once. `events` are pairs of a part of the flight and what is done then."""
        seconds = seconds or self.options.seconds
        before, sent_before = metrics(self.port), self.sent_by_nginx()
        flights = []
        for i, tour in enumerate(tours):
            record = self.folder / f"{label}-{i}-{tour}.rec"
            flights.append((tour, record, self.start(
                foreland("fly"), f"ws://127.0.0.1:{self.port}", "--tour", tour, "--seconds", seconds, "--viewport", self.options.viewport, "--tau",
                self.options.tau, "--keyframe-ms", "200", "--record", record, "--json")))
        watch = Watch(self.port, [flight for _, _, flight in flights])
        begin = time.monotonic()
        for part, event in events:
            time.sleep(max(0, begin + part * seconds - time.monotonic()))
            event()
        landed = [flight.result() for _, _, flight in flights]
        counts = watch.end()
        after = metrics(self.port)
        reports = []
        for (tour, record, _), (code, output) in zip(flights, landed):
            flown = json.loads(output) if output.strip() else {}
            reports.append({"tour": tour, "exit_code": code, "record": record, **flown})
        self.report[label] = {**summary(reports), **counts, **fetched(before, after, len(tours)),
                              "sent_by_nginx_bytes": self.sent_by_nginx() - sent_before}
        if any("jumps" in flown for flown in reports):
            self.report[label]["jumps"] = jumps_of(reports)
        self.law(all(flown["exit_code"] == 0 for flown in reports), f"{label}: a viewer did not land")
        self.law(all(flown.get("resumed", 0) + flown.get("started_afresh", 0) == 0 for flown in reports), f"{label}: a viewer was disconnected")
        self.law(self.server.is_running(), f"{label}: the server has ended")
        self.to_judge.append((label, reports))

    def sent_by_nginx(self):
        log = self.folder / "sent.log"
        return sum(int(line) for line in log.read_text().split()) if log.exists() else 0

    def end(self):
        self.stack.close()

    def judge(self):
        """Holds what was shown against the scene, when nothing else runs."""
        for label, reports in self.to_judge:
            judged = {"judged_frames": 0, "judged_keyframes": 0, "frames_stating_nothing": 0, "frames_over_stated": 0, "keyframes_over_stated": 0, "cracks": 0,
                      "holes": 0, "largest_error_px": 0}
            for flown in reports[:self.options.judge_flights]:
                if not flown["record"].exists():
                    continue
                with Program(foreland("replay"), flown["record"], "--truth", self.options.scene, "--truth-frames", self.options.judge_frames,
                             "--truth-terms-every", "0", "--json") as replay:
                    code, output = replay.result()
                if not output.strip():
                    self.broken.append(f"{self.name}, {label}: {flown['record'].name} cannot be judged (exit code {code})")
                    continue
                found = json.loads(output)
                self.law(found.get("same_sections", False), f"{label}: a replay differs")
                for key, name in (("judged_frames", "measured_frames"), ("judged_keyframes", "measured_keyframes"), ("frames_over_stated", "frames_over_tau"),
                                  ("frames_stating_nothing", "measured_frames_outside"), ("keyframes_over_stated", "keyframes_over_tau"), ("cracks", "cracks"), ("holes", "uncovered_samples")):
                    judged[key] += found[name]
                judged["frames_over_stated"] -= found["outside_frames_over_tau"]
                judged["largest_error_px"] = max(judged["largest_error_px"], found["max_error_px_frames"], found["max_error_px_keyframes"])
                if not self.options.keep:
                    flown["record"].unlink()
            self.report[label].update(judged)
            self.law(judged["judged_frames"] > 0 or self.options.judge_flights == 0, f"{label}: no frame was judged")
            for key in ("frames_over_stated", "keyframes_over_stated", "cracks", "holes"):
                self.law(judged[key] == 0, f"{label}: {judged[key]} {key}")


class Watch:
    """Looks at a server twice a second, as long as flights are in the air."""

    def __init__(self, port, flights):
        self.port, self.flights, self.seen = port, flights, []
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while any(flight.is_running() for flight in self.flights):
            with contextlib.suppress(OSError):
                counts = metrics(self.port)
                if counts.get("flying", 0) > 0:
                    self.seen.append((counts["flying"], counts.get("store_lacking", 0), counts["tolerance_px"]))
            time.sleep(0.5)

    def end(self):
        self.thread.join()
        viewers = sum(flying for flying, _, _ in self.seen) or 1
        stated = sorted(px for _, _, px in self.seen) or [0]
        return {"waiting_share": round(sum(lacking for _, lacking, _ in self.seen) / viewers, 3), "stated_px_median": round(stated[len(stated) // 2], 2),
                "stated_px_p90": round(stated[len(stated) * 9 // 10], 2)}


def summary(reports):
    total = lambda key: sum(flown.get(key, 0) for flown in reports)
    return {"viewers": len(reports), "landed": sum(flown["exit_code"] == 0 for flown in reports), "reconnected": total("resumed") + total("started_afresh"),
            "frames": total("frames"), "keyframes": total("keyframes"), "late_keyframes": total("late_keyframes"),
            "longest_gap_ms": max(flown.get("longest_gap_ms", 0) for flown in reports), "sent_bytes_per_viewer": round(total("bytes_down") / len(reports)),
            "triangles_mean": round(total("mean_triangles") / len(reports))}


def fetched(before, after, viewers):
    gained = lambda key: after.get(key, 0) - before.get(key, 0)
    if "store_capacity_bytes" not in after:
        return {}
    failures = {reason: int(gained(f'store_failures_total{{reason="{reason}"}}')) for reason in ("read", "checksum", "room")}
    return {"fetched_bytes_per_viewer": round(gained("store_fetched_bytes_total") / viewers), "fetched_bytes": int(gained("store_fetched_bytes_total")),
            "evicted_chunks": int(gained("store_evicted_chunks_total")), "cache_bytes": int(after["store_cache_bytes"]),
            "cache_most_bytes": int(after["store_capacity_bytes"]), "failures": failures}


def jumps_of(reports):
    """Of the viewers who jump, by distance: the worst recovery, and the largest tolerance stated on the way."""
    found = {}
    for flown in reports:
        for kind, jump in flown.get("jumps", {}).items():
            one = found.setdefault(kind, {"jumps": 0, "recovered": 0, "recovery_ms": 0, "first_ground_ms": 0, "largest_stated_px": 0})
            one["jumps"] += jump["jumps"]
            one["recovered"] += jump["recovered"]
            for key, name in (("recovery_ms", "recovery_ms"), ("first_ground_ms", "unguaranteed_ms"), ("largest_stated_px", "largest_tolerance_px")):
                one[key] = round(max(one[key], jump[name]), 2)
    return found


def prepared(options, folder):
    """A folder as stores have it: the scene and its checksums."""
    scene = options.scene.resolve()
    sums = Path(f"{scene}.sums")
    if not sums.exists():
        sums = folder / "scene.fls.sums"
        with Program(foreland("sums"), scene, "-o", sums) as program:
            if program.result()[0] != 0:
                sys.exit(f"foreland sums {scene} does not do")
    return scene, sums


def lay(trial, scene, sums, at="scene.fls"):
    (trial.folder / at).parent.mkdir(parents=True, exist_ok=True)
    for name, target in ((at, scene), (at.replace("scene.fls", "scene.fls.sums"), sums)):
        (trial.folder / name).unlink(missing_ok=True)
        os.symlink(target.resolve(), trial.folder / name)


def tours_of(options):
    return [TOURS[i % len(TOURS)] for i in range(options.viewers)]


def near(trial, scene, sums, link=NEAR):
    lay(trial, scene, sums)
    store = trial.start_nginx()
    trial.serve(f"http://127.0.0.1:{trial.start_link(link)}/scene.fls")
    return store


def fly_near(trial, scene, sums):
    near(trial, scene, sums)
    trial.fly(tours_of(trial.options), "flight")
    trial.law(trial.report["flight"]["fetched_bytes"] > 0, "nothing was fetched")


def fly_slow(trial, scene, sums):
    near(trial, scene, sums, SLOW)
    trial.fly(tours_of(trial.options), "flight")
    trial.law(trial.report["flight"]["waiting_share"] > 0, "nobody had to wait")


def fly_killed(trial, scene, sums):
    store = near(trial, scene, sums)
    trial.fly(tours_of(trial.options), "flight", [(1 / 3, store.kill), (2 / 3, trial.start_nginx)])
    trial.law(trial.report["flight"]["failures"]["read"] > 0, "nobody noticed that the store was dead")


def fly_garbage(trial, scene, sums):
    store = near(trial, scene, sums)
    liars = []

    def lie():
        store.kill()
        until(lambda: not answers(trial.store_port), "the end of nginx")
        liars.append(trial.start(sys.executable, Path(__file__).with_name("liar.py"), trial.folder, trial.store_port))

    def tell_the_truth():
        liars[0].kill()
        until(lambda: not answers(trial.store_port), "the end of the liar")
        trial.start_nginx()

    trial.fly(tours_of(trial.options), "flight", [(1 / 3, lie), (2 / 3, tell_the_truth)])
    failures = trial.report["flight"]["failures"]
    trial.law(failures["read"] > 0 and failures["checksum"] > 0, "nobody noticed that the store lied")


def fly_jumps(trial, scene, sums):
    near(trial, scene, sums)
    for label in ("cold", "warm"):
        trial.fly(["jumps"], label)


def fly_s3(trial, scene, sums):
    if not trial.options.s3rver:
        trial.report["skipped"] = "s3rver is not there: npm install s3rver, and --s3rver node_modules/.bin/s3rver"
        return
    bucket = trial.folder / "store/bucket"
    bucket.mkdir(parents=True, exist_ok=True)
    for name, target in (("scene.fls", scene), ("scene.fls.sums", sums)):
        at = bucket / f"{name}._S3rver_object"
        at.unlink(missing_ok=True)
        os.symlink(target.resolve(), at)
        (bucket / f"{name}._S3rver_object.md5").write_text("0" * 32)  # s3rver would read all of it to say who it is
        (bucket / f"{name}._S3rver_metadata.json").write_text("{}")
    trial.start(trial.options.s3rver, "-d", trial.folder / "store", "-a", "127.0.0.1", "-p", trial.store_port, "-s", "--no-vhost-buckets")
    until(lambda: answers(trial.store_port), "s3rver")
    trial.serve("s3://bucket/scene.fls", {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{trial.start_link(NEAR)}", "AWS_REGION": "us-east-1",
                                          "AWS_ACCESS_KEY_ID": "S3RVER", "AWS_SECRET_ACCESS_KEY": "S3RVER"})
    trial.fly(tours_of(trial.options), "flight")
    trial.law(trial.report["flight"]["fetched_bytes"] > 0, "nothing was fetched")


def fly_rclone(trial, scene, sums):
    if not trial.options.rclone or not (shutil.which("fusermount3") or shutil.which("fusermount")) or not Path("/dev/fuse").exists():
        trial.report["skipped"] = "rclone (Debian's rclone and fuse3) or /dev/fuse is not there"
        return
    lay(trial, scene, sums)
    trial.start_nginx()
    mount = trial.folder / "mount"
    mount.mkdir(exist_ok=True)
    rclone = trial.start(
        trial.options.rclone, "mount", ":http:", mount, "--http-url", f"http://127.0.0.1:{trial.start_link(NEAR)}/", "--config", "/dev/null", "--read-only",
        "--vfs-cache-mode", "full", "--vfs-cache-max-size", f"{trial.options.cache_mib}M", "--cache-dir", trial.folder / "rclone", "--vfs-read-chunk-size", "1M",
        "--vfs-cache-poll-interval", "1s")

    def unmount():
        rclone.kill(signal.SIGTERM)
        until(lambda: not rclone.is_running(), "rclone's end")

    trial.stack.callback(unmount)
    until(lambda: "scene.fls" in os.listdir(mount), "rclone's mount")
    trial.serve(mount / "scene.fls")
    for label in ("cold", "warm"):
        trial.fly(["jumps"], label)
    trial.fly(tours_of(trial.options), "flight")
    trial.report["cache_bytes"] = sum(512 * f.stat().st_blocks for f in (trial.folder / "rclone").rglob("*") if f.is_file())


def fly_local(trial, scene, _):
    trial.serve(scene)
    trial.fly(["jumps"], "jumps")
    trial.fly(tours_of(trial.options), "flight")


TRIALS = {"near": fly_near, "slow": fly_slow, "killed": fly_killed, "garbage": fly_garbage, "jumps": fly_jumps, "s3": fly_s3, "rclone": fly_rclone, "local": fly_local}


def main():
    options = parse()
    with scratch(options.keep) as folder:
        scene, sums = prepared(options, folder)
        report = {"scene_bytes": scene.stat().st_size, "cache_mib": options.cache_mib, "viewers": options.viewers, "seconds": options.seconds,
                  "viewport": options.viewport, "tau_px": float(options.tau), "trials": {}, "broken": []}
        trials = [Trial(name, options, folder) for name in options.trials]
        for trial in trials:
            say(trial.name)
            try:
                TRIALS[trial.name](trial, scene, sums)
            except (OSError, RuntimeError) as error:
                trial.broken.append(f"{trial.name}: {error}")
            finally:
                trial.end()
        for trial in trials:  # which takes all of the machine
            say(f"{trial.name}: judging")
            trial.judge()
            report["trials"][trial.name] = trial.report
            report["broken"] += trial.broken
            if options.out:
                Path(options.out).write_text(json.dumps(report, indent=1) + "\n")
    finish(report, options.out)


if __name__ == "__main__":
    main()
