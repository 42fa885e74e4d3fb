#!/usr/bin/env python3
"""Draws a column of an experiment's table against another one, as lines of different colours (docs/RESULTS.md says what columns there are).

    tools/redraw.py DIR/results.csv --x round_trip_ms --y total_p99_px --by strategy,predictor [--where tau_px=1] [--log] -o FIGURE.svg
    tools/redraw.py DIR/in_time.csv --x time_s --y in_time --by balance -o FIGURE.svg

A table that has a row for each frame, step or look names the row of results.csv in its first column; that row's columns can be asked for, too.
Equal tables give equal bytes. Needs Python alone.
"""

import argparse
import csv
import math
import os
import sys

from svg import Canvas

COLOURS = ["#2f6fb0", "#d9591c", "#11865a", "#7a4fb5", "#c2183c", "#8a6d00", "#3b8ea5", "#555555"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 760, 420, 70, 200, 20, 50


def rows_of(path):
    """The table's rows, with those of results.csv beside it where it has one."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    parent = os.path.join(os.path.dirname(path), "results.csv")
    first = next(iter(rows[0]), "") if rows else ""
    if first in ("run", "cell", "flight") and os.path.basename(path) != "results.csv" and os.path.exists(parent):
        with open(parent, newline="", encoding="utf-8") as file:
            of = list(csv.DictReader(file))
        rows = [{**of[int(row[first])], **row} for row in rows]
    return rows


def lines_of(rows, x, y, by, where):
    """Points by the words of the columns `by`, in the order in which these come."""
    lines = {}
    for row in rows:
        missing = [name for name in [x, y, *by, *where] if name not in row]
        if missing:
            sys.exit(f"there is no column '{missing[0]}'; choose from {', '.join(row)}")
        if all(row[name] == value for name, value in where.items()):
            lines.setdefault(" ".join(row[name] for name in by), []).append((float(row[x]), float(row[y])))
    return {name: sorted(p for p in ps if all(map(math.isfinite, p))) for name, ps in lines.items()}


def ticks(low, high):
    step = 10 ** math.floor(math.log10((high - low) / 4))
    step = next(step * m for m in (1, 2, 5, 10) if (high - low) / (step * m) <= 6)
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def span(values, has_zero):
    low, high = min(values), max(values)
    low = min(low, 0) if has_zero else low
    return low, high if high > low else low + 1


def draw(lines, x, y, is_log):
    canvas = Canvas(WIDTH, HEIGHT)
    points = [p for ps in lines.values() for p in ps if not is_log or p[1] > 0]
    if not points:
        sys.exit("no row has both; look at --where")
    level = math.log10 if is_log else float
    (x0, x1), (y0, y1) = span([p[0] for p in points], True), span([level(p[1]) for p in points], not is_log)

    def at(p):
        return LEFT + (p[0] - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - (level(p[1]) - y0) / (y1 - y0) * (HEIGHT - TOP - BOTTOM)

    shown = [10**e for e in range(math.ceil(y0), math.floor(y1) + 1)] if is_log else ticks(y0, y1)
    for value in shown:
        height = at((x0, value))[1]
        canvas.line([(LEFT, height), (WIDTH - RIGHT, height)], stroke="#dddddd")
        canvas.text(LEFT - 8, height + 4, f"{value:g}", anchor="end")
    for value in ticks(x0, x1):
        canvas.text(at((value, points[0][1]))[0], HEIGHT - BOTTOM + 20, f"{value:g}", anchor="middle")
    for number, (name, ps) in enumerate(lines.items()):
        colour = COLOURS[number % len(COLOURS)]
        places = [at(p) for p in ps if not is_log or p[1] > 0]
        canvas.line(places, stroke=colour, stroke_width=2)
        if len(places) <= 40:
            canvas.dots(places, 3, colour)
        canvas.text(WIDTH - RIGHT + 12, TOP + 14 + 18 * number, name, fill=colour)
    canvas.text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 10, x, anchor="middle")
    canvas.text(LEFT, TOP - 6, y)
    return canvas.document()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table")
    parser.add_argument("--x", required=True)
    parser.add_argument("--y", required=True)
    parser.add_argument("--by", default="", help="columns whose values make a line each")
    parser.add_argument("--where", action="append", default=[], metavar="COLUMN=VALUE")
    parser.add_argument("--log", action="store_true", help="the upright axis by powers of ten")
    parser.add_argument("-o", "--output", required=True)
    args = parser.parse_args()
    where = dict(condition.split("=", 1) for condition in args.where)
    lines = lines_of(rows_of(args.table), args.x, args.y, [name for name in args.by.split(",") if name], where)
    with open(args.output, "w", encoding="utf-8") as file:
        file.write(draw(lines, args.x, args.y, args.log))


if __name__ == "__main__":
    main()
