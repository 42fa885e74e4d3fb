#!/usr/bin/env python3
"""A scene by jobs of blocks, by Snakemake and by hand, while jobs and Snakemake are killed, disks are full and inputs change: one scene each time.

    lab/trials/blocks.py [--side 4201] [--tiles 4] [--jobs 1 2 3 7] [--snakemake PATH] [--seed 1] [--out FILE.json]

Cuts a synthetic landscape into tiles (gdal_translate), builds the scene of them at once, and then with deploy/Snakefile and its profile for
this machine. Every scene is compared with that one, to the byte. Prints JSON; exits 1 if a scene differs, a job takes more memory than the plan says,
more is made again than an input reaches, or something half-written stays. The full disk is a tmpfs, which needs root. Snakemake is Debian's package;
programs are those of FORELAND_BIN (default build/release/bin).

    memory        `foreland block` for every block in random order, two at once: the most that one took
    order         Snakemake with so many jobs, random halves of the blocks first
    job           Snakemake, one of whose jobs gets SIGKILL
    snakemake     Snakemake gets SIGKILL with all of its jobs, and is started again
    full          a disk with room for some blocks, then for all blocks but not for the scene, then for both
    input         one tile is replaced by another one
    dressed       voids, a picture and coded pages beside the ground
    epochs        ground that changes in time, of which the file of one date is replaced by another one
    slurm         a job of Slurm for each block, where sbatch is (a controller and a node of this machine's will do)
"""

import argparse
import contextlib
import hashlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from running import BIN, ROOT, Program, finish, foreland, say, scratch, until


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--side", type=int, default=4201, help="samples of the landscape")
    parser.add_argument("--tiles", type=int, default=4, help="a side")
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2, 3, 7])
    parser.add_argument("--snakemake", default=shutil.which("snakemake"))
    parser.add_argument("--trials", nargs="+", choices=TRIALS, default=list(TRIALS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="a folder for what is made")
    parser.add_argument("--out")
    return parser.parse_args()


def must(*words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest() if hasattr(hashlib, "file_digest") else hashlib.sha256(file.read()).hexdigest()


def build(inputs, scene, *more):
    """At once, as a reference: digest and id."""
    must(foreland("build"), *inputs, "--frame", "planar", *more, "-o", scene)
    return digest(scene), json.loads(must(foreland("info"), "--json", scene))["id"]


class Trial:
    def __init__(self, options, folder):
        self.options, self.folder, self.chance = options, folder, random.Random(options.seed)
        self.report, self.broken = {}, []
        self.tiles = folder / "tiles"
        self.tiles.mkdir()
        must(foreland("synth"), "--size", options.side, "--spacing", "10", "--seed", options.seed, "-o", folder / "land.tif")
        self.cut(folder / "land.tif", range(options.tiles**2))
        self.scene = folder / "at_once.fls"
        self.wanted, self.id = build(self.inputs(), self.scene)

    def cut(self, source, numbers, into=None):
        side, tiles = self.options.side, self.options.tiles
        ends = [side * i // tiles for i in range(tiles + 1)]
        for number in numbers:
            (x, x1), (y, y1) = ((ends[k], ends[k + 1]) for k in (number % tiles, number // tiles))
            must("gdal_translate", "-q", "-srcwin", x, y, x1 - x, y1 - y, "-co", "TILED=YES", source, (into or self.tiles) / f"{number:03}.tif")

    def inputs(self, tiles=None):
        return sorted((tiles or self.tiles).glob("*.tif"))

    def law(self, holds, text):
        if not holds:
            self.broken.append(text)

    def is_the_scene(self, scene, text, wanted=None):
        is_same = scene.exists() and digest(scene) == (wanted or self.wanted)
        self.law(is_same, f"{text}: another scene than at once")
        return is_same

    def nothing_half_written(self, folder, text):
        """Blocks are whole, which `foreland block` would not touch, and nothing else is there."""
        strangers = [str(path) for path in folder.rglob("*") if path.is_file() and path.suffix not in (".block", ".json", ".fls", ".voids") and ".snakemake" not in path.parts]
        self.law(not strangers, f"{text}: left behind {strangers}")

    def snakemake(self, scene, jobs, targets=(), profile="local", tiles=None, more="", also=""):
        """Snakemake with its folder, its scene's, as its own. `more`: what foreland plan takes beside, and `also` the files of that."""
        return Program(self.options.snakemake, *targets, "-s", ROOT / "deploy/Snakefile", "--profile", ROOT / "deploy/snakemake" / profile, "--cores", jobs, "--jobs", jobs,
                       "--config", f"inputs={tiles or self.tiles}/*.tif", f"options=--frame planar {more}", f"also={also}", f"scene={scene}", f"threads={min(4, os.cpu_count())}",
                       f"foreland={BIN / 'foreland'}", cwd=scene.parent, log=self.folder / "snakemake.log")

    def room(self, name):
        folder = self.folder / name
        folder.mkdir()
        return folder / "scene.fls"

    def run(self, scene, jobs, targets=(), **more):
        with self.snakemake(scene, jobs, targets, **more) as program:
            return program.result()[0]


def plan_of(scene):
    return json.loads(Path(f"{scene}.work/plan.json").read_text())


def blocks_of(scene):
    return {path.name: path.stat().st_mtime_ns for path in Path(f"{scene}.work/blocks").glob("*.block")}


def measure_memory(trial):
    plan = trial.folder / "plan.json"
    must(foreland("plan"), *trial.inputs(), "--frame", "planar", "-o", plan)
    said = json.loads(plan.read_text())
    numbers = list(range(len(said["blocks"])))
    trial.chance.shuffle(numbers)
    most, running = 0, {}
    while numbers or running:
        while numbers and len(running) < 2:
            number = numbers.pop()
            running[os.posix_spawn(foreland("block"), ["foreland-block", str(plan), str(number), "-o", str(trial.folder / "blocks")], os.environ)] = number
        process, status, usage = os.wait3(0)
        trial.law(status == 0, f"memory: block {running.pop(process)} failed")
        most = max(most, usage.ru_maxrss / 1024)
    scene = trial.folder / "by_hand.fls"
    must(foreland("merge"), plan, trial.folder / "blocks", "-o", scene)
    trial.is_the_scene(scene, "memory")
    trial.law(most <= said["memory_mib"], f"memory: a block took {most:.0f} MiB of the {said['memory_mib']} that the plan says")
    trial.report["memory"] = {"blocks": len(said["blocks"]), "plan_mib": said["memory_mib"], "most_mib": round(most)}
    shutil.rmtree(trial.folder / "blocks")
    scene.unlink()


def run_in_any_order(trial):
    trial.report["order"] = {}
    for jobs in trial.options.jobs:
        scene = trial.room(f"order-{jobs}")
        begin = time.monotonic()
        trial.law(trial.run(scene, jobs, [f"{scene}.work/plan.json"]) == 0, f"order: no plan with {jobs} jobs")
        ids = [block["id"] for block in plan_of(scene)["blocks"]]
        some = trial.chance.sample(ids, len(ids) // 2)
        trial.law(trial.run(scene, jobs, [f"{scene}.work/blocks/{each}.block" for each in some]) == 0, f"order: no blocks with {jobs} jobs")
        trial.law(trial.run(scene, jobs) == 0, f"order: Snakemake failed with {jobs} jobs")
        trial.report["order"][jobs] = {"same": trial.is_the_scene(scene, f"order, {jobs} jobs"), "seconds": round(time.monotonic() - begin, 1)}
        shutil.rmtree(scene.parent)


def children(process):
    """Of a process and of theirs: id and name of each."""
    found, waiting = [], [process]
    while waiting:
        parent = waiting.pop()
        with contextlib.suppress(OSError):
            for task in Path(f"/proc/{parent}/task").iterdir():
                for child in (task / "children").read_text().split():
                    waiting.append(int(child))
                    found.append((int(child), (Path(f"/proc/{child}/comm").read_text()).strip()))
    return found


def kill_a_job(trial):
    scene = trial.room("job")
    with trial.snakemake(scene, 2) as program:
        job = until(lambda: next((p for p, name in children(program.id) if name == "foreland-block"), None), "a job")
        os.kill(job, signal.SIGKILL)
        code = program.result()[0]
    trial.law(code == 0, "job: Snakemake did not make it again")
    trial.report["job"] = {"same": trial.is_the_scene(scene, "job")}
    shutil.rmtree(scene.parent)


def kill_snakemake(trial):
    scene = trial.room("snakemake")
    with trial.snakemake(scene, 2) as program:
        until(lambda: len(blocks_of(scene)) >= 3, "three blocks")
        program.kill()
        program.result()
    before = blocks_of(scene)
    trial.law(not scene.exists(), "snakemake: a scene before its time")
    code = trial.run(scene, 2)
    trial.law(code == 0, "snakemake: it does not go on")
    after = blocks_of(scene)
    kept = sum(after.get(name) == at for name, at in before.items())
    trial.nothing_half_written(Path(f"{scene}.work"), "snakemake")
    trial.report["snakemake"] = {"same": trial.is_the_scene(scene, "snakemake"), "blocks_before": len(before), "of_these_kept": kept}
    shutil.rmtree(scene.parent)


def fill_the_disk(trial):
    """Room for a third of the blocks, then for them all but nothing else, for half the scene, and for all."""
    block_bytes, count, scene_bytes = 4.3 * 1024 * 1024, len(plan_of_inputs(trial)["blocks"]), trial.scene.stat().st_size
    disk = trial.folder / "full"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "tmpfs", disk], check=False, capture_output=True).returncode != 0:
        trial.report["full"] = {"skipped": "a tmpfs needs root"}
        return
    try:
        scene, said = disk / "scene.fls", []

        def run_within(size):
            must("mount", "-o", f"remount,size={int(size)}", disk)
            log = trial.folder / "snakemake.log"
            begin = log.stat().st_size if log.exists() else 0
            code = trial.run(scene, 2)
            errors = re.findall(r"^foreland (?:block|merge|plan): .*$", log.read_bytes()[begin:].decode(errors="replace"), re.M)
            said.append({"bytes": int(size), "exit_code": code, "failed": len(errors), "first_error": errors[0] if errors else None})
            trial.nothing_half_written(disk, "full")
            return code

        trial.law(run_within(count * block_bytes / 3) != 0, "full: a third of the blocks was enough")
        # The blocks by hand, for Snakemake would go on to the scene.
        must("mount", "-o", f"remount,size={int(2 * count * block_bytes)}", disk)
        must(foreland("block"), f"{scene}.work/plan.json", *range(count), "-o", f"{scene}.work/blocks")
        used = shutil.disk_usage(disk).used
        for size in (used + (1 << 18), used + scene_bytes / 2):
            trial.law(run_within(size) != 0, f"full: {int(size)} bytes were enough")
        for one in said:
            trial.law(one["first_error"] and str(disk) in one["first_error"] and re.search(r"No space left.*; .*MiB", one["first_error"]),
                      f"full: no error that names the file and the way out: {one['first_error']}")
        trial.law(run_within(used + 3 * scene_bytes) == 0, "full: it does not go on when there is room")
        trial.report["full"] = {"same": trial.is_the_scene(scene, "full"), "disks": said}
    finally:
        must("umount", disk)


def plan_of_inputs(trial):
    plan = trial.folder / "inputs.json"
    must(foreland("plan"), *trial.inputs(), "--frame", "planar", "-o", plan)
    return json.loads(plan.read_text())


def replace_an_input(trial):
    scene = trial.room("input")
    trial.law(trial.run(scene, 2) == 0, "input: Snakemake failed")
    before = blocks_of(scene)
    number = trial.chance.randrange(trial.options.tiles**2)
    must("gdal_calc.py", "-A", trial.folder / "land.tif", "--calc", "A*0.5+A.mean()*0.5", "--outfile", trial.folder / "other.tif", "--quiet")
    trial.cut(trial.folder / "other.tif", [number])
    wanted, _ = build(trial.inputs(), trial.folder / "other.fls")
    trial.law(trial.run(scene, 2) == 0, "input: Snakemake failed after a change")
    after = blocks_of(scene)
    again = sum(before.get(name) != at for name, at in after.items())
    plan = plan_of(scene)
    is_same = trial.is_the_scene(scene, "input", wanted)
    reached = reached_by(trial, number, plan)
    trial.law(again <= reached, f"input: {again} blocks were made again, and the tile reaches {reached}")
    trial.report["input"] = {"same": is_same, "blocks": len(plan["blocks"]), "made_again": again, "reached": reached}


def reached_by(trial, number, plan):
    """Blocks of 1024 samples, from the south-west on, that a tile and 32 samples around it touch. Tiles are counted from the north-west on."""
    side, tiles, block, halo = trial.options.side, trial.options.tiles, 1024, 32
    count = 1
    for k in (number % tiles, tiles - 1 - number // tiles):
        begin, end = side * k // tiles - halo - 1, side * (k + 1) // tiles + halo + 1
        count *= min((side - 1) // block, end // block) - max(0, begin // block) + 1
    return min(count, len(plan["blocks"]))


def dress(trial):
    """Voids in the valleys, in a corner and as specks, and a picture that is twice as fine as the ground."""
    tiles, land, picture = trial.folder / "dressed_tiles", trial.folder / "dressed.tif", trial.folder / "picture.tif"
    tiles.mkdir()
    must("gdal_calc.py", "-A", trial.folder / "land.tif", "--quiet", "--NoDataValue=-9999", "--outfile", land, "--calc",
         "numpy.where((A < numpy.percentile(A, 5)) | (numpy.add.outer(numpy.arange(A.shape[0]), numpy.arange(A.shape[1])) < A.shape[0] // 3) | (numpy.modf(A * 977)[0] < 0.01), -9999, A)")
    trial.cut(land, range(trial.options.tiles**2), tiles)
    must(foreland("synth"), "--imagery", picture, "--imagery-detail", 2, "--over", trial.folder / "land.tif")
    more = ["--imagery", picture, "--pages", "coded"]
    wanted, _ = build(trial.inputs(tiles), trial.folder / "dressed.fls", *more)
    scene = trial.room("dressed")
    trial.law(trial.run(scene, 2, tiles=tiles, more=" ".join(map(str, more)), also=picture) == 0, "dressed: Snakemake failed")
    trial.nothing_half_written(Path(f"{scene}.work"), "dressed")
    said = json.loads(must(foreland("info"), "--json", scene))
    trial.law(said["voids_filled"] > 0, "dressed: there were no voids")
    trial.report["dressed"] = {"same": trial.is_the_scene(scene, "dressed", wanted), "voids_filled": said["voids_filled"]}
    shutil.rmtree(scene.parent)


def change_in_time(trial):
    """The ground everywhere at one date, and that of one tile at the next one."""
    scene, surveys = trial.room("epochs"), trial.folder / "surveys"
    surveys.mkdir()
    number = trial.chance.randrange(trial.options.tiles**2)

    def survey(expression, outfile):
        must("gdal_calc.py", "-A", trial.folder / "land.tif", "--calc", expression, "--outfile", outfile, "--quiet", "--overwrite")

    def step(text):
        survey({"before": "A*0.7", "after": "A*0.8"}[text], trial.folder / "then.tif")
        trial.cut(trial.folder / "then.tif", [number], surveys)
        wanted, _ = build(trial.inputs(), trial.folder / "epochs.fls", *more)
        trial.law(trial.run(scene, 2, more=" ".join(map(str, more)), also=f"{everywhere} {surveys}/*.tif") == 0, f"epochs: Snakemake failed {text}")
        trial.nothing_half_written(Path(f"{scene}.work"), "epochs")
        return trial.is_the_scene(scene, f"epochs {text}", wanted), blocks_of(scene)

    everywhere = trial.folder / "everywhere.tif"
    survey("A*0.9", everywhere)
    more = ["--epoch", f"2001-01-01={trial.tiles}/{number:03}.tif", "--epoch", f"2002-01-01={everywhere}", "--epoch", f"2003-01-01={surveys}/{number:03}.tif", "--epoch-blend", "b-spline"]
    is_same_before, before = step("before")
    is_same, after = step("after")
    again, plan = sum(before.get(name) != at for name, at in after.items()), plan_of(scene)
    reached = reached_by(trial, number, plan)
    trial.law(0 < again <= reached, f"epochs: {again} blocks were made again, and the survey reaches {reached}")
    trial.report["epochs"] = {"same": is_same_before and is_same, "blocks": len(plan["blocks"]), "made_again": again, "reached": reached, "memory_mib": plan["memory_mib"]}
    shutil.rmtree(scene.parent)


def run_by_slurm(trial):
    if not shutil.which("sbatch") or subprocess.run(["sinfo"], check=False, capture_output=True).returncode != 0:
        trial.report["slurm"] = {"skipped": "no Slurm answers here: Debian's slurmctld, slurmd and slurm-client, with a slurm.conf of one node"}
        return
    scene = trial.room("slurm")
    trial.law(trial.run(scene, 7, profile="slurm") == 0, "slurm: Snakemake failed")
    trial.report["slurm"] = {"same": trial.is_the_scene(scene, "slurm")}
    shutil.rmtree(scene.parent)


TRIALS = {"memory": measure_memory, "order": run_in_any_order, "job": kill_a_job, "snakemake": kill_snakemake, "full": fill_the_disk, "input": replace_an_input,
          "dressed": dress, "epochs": change_in_time, "slurm": run_by_slurm}


def main():
    options = parse()
    if not options.snakemake:
        sys.exit("snakemake is not there: install Debian's package, or name it with --snakemake")
    with scratch(options.keep) as folder:
        trial = Trial(options, folder)
        for name in options.trials:
            say(name)
            TRIALS[name](trial)
    finish({"side": options.side, "inputs": options.tiles**2, "id": trial.id, **trial.report, "broken": trial.broken}, options.out)


if __name__ == "__main__":
    main()
