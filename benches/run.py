#!/usr/bin/env python3
"""treegen beside Embree and POV-Ray on the same scenes: rays a second of one core's time, memory, and what was seen.

Builds all, exports each scene from its program, then runs the contenders in turn (A B C A B C ...), so that whatever
else the machine does falls on all of them. README.md says what is measured and what is needed.

    benches/run.py                          the usual scenes
    benches/run.py s1/8 s2 --rounds 3       these, three times
    benches/run.py s1/12 --skip povray,embree-flat
"""

import argparse
import json
import os
import re
import shlex
import statistics
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target" / "peers"
USUAL = ["s1/6", "s1/8", "s1/10", "s1/12", "s1/14", "s2", "s4", "pine"]
ORDERS = {"s1": ("Sierpinski.order", 10), "s2": ("Sympodial.order", 11), "leafy": ("Sympodial.order", 11), "s4": ("Terrain.order", 8), "pine": ("Pine.height", 15)}
# So many pixels may come out otherwise in single precision, or with another way to round. Which way a facet far smaller
# than a pixel faces is a matter of rounding more often than whether something is hit.
TOLERANCES = {"hits": 10, "shadow": 20}
# Expanded scenes with more primitives than this are left out: POV-Ray takes 5 KB for each.
MOST_PRIMITIVES = 2_000_000


def main():
    arguments = parse_arguments()
    WORK.mkdir(parents=True, exist_ok=True)
    tools = build(arguments.skip)
    agree = True
    with open(WORK / "results.jsonl", "w") as results:
        for name in arguments.scenes or USUAL:
            scene = Scene(name, tools)
            rows = race(contenders(scene, arguments), arguments.rounds)
            results.writelines(json.dumps(dict(row, scene=name)) + "\n" for row in rows)
            agree &= report(name, rows)
            scene.clean()
    sys.exit(0 if agree else 1)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="s1/ORDER, s2, s2/ORDER, leafy, leafy/ORDER, s4, s4/ORDER, pine, pine/HEIGHT; usually " + " ".join(USUAL))
    parser.add_argument("--rounds", type=int, default=5, help="how often each contender has its turn (5)")
    parser.add_argument("--frames", type=int, default=5, help="frames a turn, of those that make more than one (5)")
    parser.add_argument(
        "--skip", default="", help="contenders to leave out, by the beginnings of their names, with commas"
    )
    parser.add_argument(
        "--also",
        action="append",
        default=[],
        metavar="SCENE:NAME=COMMAND",
        help="another contender: a command whose last line is JSON with mrays_s_core",
    )
    arguments = parser.parse_args()
    arguments.skip = tuple(it for it in arguments.skip.split(",") if it)
    return arguments


def build(skip):
    """The paths of all programs."""
    cargo("build", "--release")
    lines = cargo("bench", "--bench", "frames", "--no-run", "--message-format", "json").splitlines()
    built = [json.loads(it) for it in lines if it.startswith("{")]
    frames = next(it["executable"] for it in built if it.get("executable") and it["target"]["name"] == "frames")
    if "embree" not in skip:
        source = ROOT / "benches" / "embree" / "main.cpp"
        options = "-O3 -march=native -fno-math-errno -std=c++17 -Wall -Wextra".split()
        run(["g++", *options, "-o", WORK / "embree", source, "-lembree3"])
    return {"treegen": ROOT / "target" / "release" / "treegen", "frames": frames, "embree": WORK / "embree"}


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def run(command):
    """Runs a command and gives what it printed. One that fails ends all."""
    command = [str(it) for it in command]
    ran = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if ran.returncode != 0:
        failed(command, ran.returncode, ran.stderr + ran.stdout)
    return ran.stdout


def failed(command, code, said):
    sys.exit(f"{shlex.join(command)}\nended with {code}:\n{said[-2000:]}")


def run_measured(command):
    """Runs a command and gives what it printed, and the most memory that it held at once, in MB."""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read()
    if process.returncode != 0:
        failed(command, process.returncode, text)
    return text, usage.ru_maxrss / 1024


class Scene:
    """A program with an order, and its exports as far as they were asked for."""

    def __init__(self, name, tools):
        kind, _, order = name.partition("/")
        if kind not in ORDERS:
            sys.exit(f"there is no scene {name}")
        self.name, self.kind, self.tools = name, kind, tools
        self.parameter, usual = ORDERS[kind]
        self.order = int(order or usual)
        self.program = ROOT / "benches" / "scenes" / f"{kind}.tg"
        self.exports = {}
        # What was seen, by treegen's own count: the rates of contenders that do not count are found with it.
        self.rays = None

    def set(self, order=None):
        return ["--set", f"{self.parameter}={order or self.order}"]

    def export(self, form, order=None):
        order = order or self.order
        path = WORK / f"{self.kind}-{order}.{form}"
        if path not in self.exports.values():
            options = f"--expand --format {form} --limit 1000000000 -q".split()
            run([self.tools["treegen"], "inspect", self.program, *options, "-o", path, *self.set(order)])
            self.exports[form, order] = path
        return path

    def clean(self):
        for path in self.exports.values():
            path.unlink()


def contenders(scene, arguments):
    """The name of each contender, and a function that gives it a turn."""
    all_of_them = {"treegen": lambda: treegen(scene), "treegen-later": lambda: later(scene, arguments.frames)}
    fits = scene.kind != "s1" or 4**scene.order <= MOST_PRIMITIVES
    for width in (16, 8, 1) if fits else ():
        all_of_them[f"embree-flat-{width}"] = lambda width=width: embree(scene, width, arguments.frames)
    if scene.kind == "s1":
        # Packets of 16 never come back from instances in Embree 3.13.
        all_of_them["embree-instances-8"] = lambda: embree_instances(scene, 8, arguments.frames)
    if fits:
        all_of_them["povray"] = lambda: povray(scene, "+BM1")
        all_of_them["povray-bsp"] = lambda: povray(scene, "+BM2")
    for given in arguments.also:
        place, _, command = given.partition("=")
        where, _, name = place.partition(":")
        if where == scene.name:
            all_of_them[name] = lambda command=command: other(command)
    return {name: turn for name, turn in all_of_them.items() if not name.startswith(arguments.skip or ("-",))}


def race(turns, rounds):
    """All turns of all contenders, and of each the medians."""
    rows = {name: [] for name in turns}
    for number in range(rounds):
        for name, turn in turns.items():
            print(f"\r{number + 1}/{rounds} {name:24}", end="", file=sys.stderr, flush=True)
            rows[name].append(turn())
    print("\r" + " " * 40 + "\r", end="", file=sys.stderr)
    first = next(iter(rows))
    return [middle(name, turns, rows[first]) for name, turns in rows.items()]


def middle(name, turns, first):
    rates = [it["rate"] for it in turns]
    ratios = [it["rate"] / other["rate"] for it, other in zip(turns, first)]
    row = dict(
        turns[0],
        name=name,
        rate=statistics.median(rates),
        least=min(rates),
        most=max(rates),
        ratio=statistics.median(ratios),
    )
    row["before"] = statistics.median(it["before"] for it in turns)
    return row


def report(name, rows):
    """Prints a table. Whether all have seen the same."""
    print(f"\n{name}\n")
    print("| contender | Mrays/s a core | least to most | to treegen | before, CPU s | peak MB | hits | shadow rays |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: |")
    agree = True
    for row in rows:
        counts = {what: row.get(what) for what in TOLERANCES}
        known = [(what, mine, rows[0].get(what)) for what, mine in counts.items()]
        fits = all(None in (mine, first) or abs(mine - first) <= TOLERANCES[what] for what, mine, first in known)
        agree &= fits
        hits, shadow = ("" if it is None else it for it in counts.values())
        numbers = "{name} | {rate:.2f} | {least:.2f} to {most:.2f} | {ratio:.2f} | {before:.3f} | {peak:.0f}".format(
            **row
        )
        print(f"| {numbers} | {hits} | {shadow} |" + ("" if fits else " **differs**"), flush=True)
    return agree


def treegen(scene):
    picture, stats = WORK / "treegen.png", WORK / "treegen.json"
    options = ["--samples", "1", "--detail", "0", "--threads", "1", "-q", "--stats", stats, "-o", picture]
    run([scene.tools["treegen"], scene.program, *options, *scene.set()])
    numbers = json.loads(stats.read_text())
    scene.rays = numbers["rays"]["camera"] + numbers["rays"]["shadow"]
    return dict(
        rate=scene.rays / numbers["cpu_seconds"]["render"] / 1e6,
        before=numbers["seconds"]["compile"] + numbers["seconds"]["prepare"],
        peak=numbers["peak_rss_bytes"] / 2**20,
        hits=opaque_pixels(picture),
        shadow=numbers["rays"]["shadow"],
    )


def later(scene, frames):
    numbers = last_line([scene.tools["frames"], scene.program, "--frames", frames, *scene.set()])
    scene.rays = numbers["camera"] + numbers["shadow"]
    return dict(
        rate=numbers["later_mrays_s_core"],
        before=numbers["prepare_cpu_s"] + numbers["first_cpu_s"],
        peak=numbers["peak_rss_mb"],
        hits=numbers["hits"],
        shadow=numbers["shadow"],
    )


def embree(scene, width, frames):
    return embree_row(last_line([scene.tools["embree"], scene.export("json"), width, frames]))


def embree_instances(scene, width, frames):
    base = scene.order // 2
    return embree_row(
        last_line(
            [scene.tools["embree"], scene.export("json", base), width, frames, scene.export("json", scene.order - base)]
        )
    )


def embree_row(numbers):
    return dict(
        rate=numbers["later_mrays_s_core"],
        before=numbers["build_cpu_s"],
        peak=numbers["peak_rss_mb"],
        hits=numbers["hits"],
        shadow=numbers["shadow"],
    )


def povray(scene, bounding):
    """A run of POV-Ray: it says what it took, and its picture what it saw. Its shadow rays are not told."""
    picture = WORK / "povray.tga"
    options = f"+W512 +H512 +WT1 +FT +UA -A -D -V {bounding}".split()
    command = ["povray", f"+I{scene.export('pov')}", f"+O{picture}", *options]
    said, peak = run_measured(command)
    seconds = {
        step: float(time)
        for step, time in re.findall(r"(Parse|Bounding|Trace) Time:.*?with ([\d.]+) CPU-seconds", said, re.S)
    }
    if scene.rays is None:
        treegen(scene)
    return dict(
        rate=scene.rays / seconds["Trace"] / 1e6,
        before=seconds["Parse"] + seconds.get("Bounding", 0),
        peak=peak,
        hits=sum(it > 0 for it in picture.read_bytes()[18 + 3 : 18 + 512 * 512 * 4 : 4]),
    )


def other(command):
    numbers = last_line(shlex.split(command))
    return dict(
        rate=numbers["mrays_s_core"],
        before=numbers.get("build_s", 0),
        peak=numbers.get("peak_rss_mb", 0),
        hits=numbers.get("hits"),
        shadow=numbers.get("shadow_rays"),
    )


def last_line(command):
    return json.loads(run(command).strip().splitlines()[-1])


def opaque_pixels(path):
    """How many pixels of an 8-bit RGBA picture are not clear."""
    data, chunks, at = path.read_bytes(), b"", 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", data, at + 8)
            assert (depth, color) == (8, 6), "the picture is not 8-bit RGBA"
        if kind == b"IDAT":
            chunks += data[at + 8 : at + 8 + length]
        at += length + 12
    return sum(it > 0 for it in unfiltered(zlib.decompress(chunks), width, height)[3::4])


def unfiltered(data, width, height):
    """The bytes of a PNG (8-bit RGBA), row by row, with the filters of its rows undone."""
    size, above, rows = width * 4, bytearray(width * 4), bytearray()
    for row in range(height):
        kind, line = data[row * (size + 1)], bytearray(data[row * (size + 1) + 1 : (row + 1) * (size + 1)])
        for i in range(size) if kind else ():
            left, up, corner = (line[i - 4], above[i], above[i - 4]) if i >= 4 else (0, above[i], 0)
            if kind == 4:
                by_left, by_up, by_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
                guess = left if by_left <= by_up and by_left <= by_corner else up if by_up <= by_corner else corner
            else:
                guess = (0, left, up, (left + up) // 2)[kind]
            line[i] = (line[i] + guess) & 255
        rows += line
        above = line
    return rows


if __name__ == "__main__":
    main()
