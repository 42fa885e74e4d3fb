#!/usr/bin/env python3
"""Judges what the page measures by NumPy on rasters that GDAL reads, and by PROJ's geod. lab/client/measures.mjs runs it.

    raster_truth.py extent FILE RASTER          where the raster's first and last samples are
    raster_truth.py profiles FILE RASTER        FILE: x, y, height of places; how far heights are off the raster's, bilinear
    raster_truth.py areas FILE KIND             FILE: area, number of corners, x and y of each, of rings; KIND: planar or geographic
    raster_truth.py volume FILE BEFORE AFTER    FILE: west, east, south, north of a box, and what it gained

FILE holds doubles. Prints JSON.
"""
import json
import subprocess
import sys

import numpy as np
from osgeo import gdal

gdal.UseExceptions()


class Raster:
    """Samples, NaN where there are none, at the middles of their pixels."""

    def __init__(self, path):
        dataset = gdal.Open(path)
        band = dataset.GetRasterBand(1)
        self.samples = band.ReadAsArray().astype(np.float64)
        nodata = band.GetNoDataValue()
        if nodata is not None:
            self.samples[self.samples == nodata] = np.nan
        left, self.dx, _, top, _, self.dy = dataset.GetGeoTransform()  # dy is negative
        self.x0, self.y0 = left + self.dx / 2, top + self.dy / 2

    def extent(self):
        rows, columns = self.samples.shape
        return (self.x0, self.x0 + (columns - 1) * self.dx), (self.y0 + (rows - 1) * self.dy, self.y0)

    def at(self, x, y):
        """Bilinear between the four samples around each place; NaN where one of them is."""
        rows, columns = self.samples.shape
        u, v = (np.asarray(x) - self.x0) / self.dx, (np.asarray(y) - self.y0) / self.dy
        i, j = np.clip(np.floor(u).astype(int), 0, columns - 2), np.clip(np.floor(v).astype(int), 0, rows - 2)
        s, t = u - i, v - j
        h = self.samples
        return (1 - t) * ((1 - s) * h[j, i] + s * h[j, i + 1]) + t * ((1 - s) * h[j + 1, i] + s * h[j + 1, i + 1])


def judge_extent(_, raster):
    x, y = Raster(raster).extent()
    return {"x": x, "y": y}


def judge_profiles(numbers, raster):
    x, y, height = numbers.reshape(-1, 3).T
    off = np.abs(height - Raster(raster).at(x, y))
    known = np.isfinite(off)
    return {"places": len(off), "beside_voids": int(np.sum(~known)), "largest_m": float(np.max(off[known])), "rms_m": float(np.sqrt(np.mean(off[known] ** 2)))}


def geod(arguments, rows):
    text = "".join(" ".join(f"{value:.12f}" for value in row) + "\n" for row in rows)
    printed = subprocess.run(["geod", "+ellps=WGS84", *arguments], input=text, capture_output=True, text=True, check=True).stdout
    return np.array([[float(word) for word in line.split()] for line in printed.splitlines()])


PIECES = 400  # of an edge, between which longitude and what the area is of are taken to be straight


def geodesic_areas(rings):
    """Square metres inside of rings of geodesics, by the integral of the zones of the ellipsoid beneath them."""
    edges = [(ring[i, ::-1], ring[(i + 1) % len(ring), ::-1]) for ring in rings for i in range(len(ring))]
    azimuths = geod(["-I", "-f", "%.12f", "-F", "%.9f"], [np.concatenate(edge) for edge in edges])
    ways = [(start[0], start[1], azimuth, length * k / PIECES) for (start, _), (azimuth, _, length) in zip(edges, azimuths) for k in range(PIECES)]
    points = geod(["-f", "%.13f"], ways)[:, :2].reshape(len(edges), PIECES, 2)
    a, flattening = 6378137.0, 1 / 298.257223563
    b, e = a * (1 - flattening), np.sqrt(flattening * (2 - flattening))
    first, areas = 0, []
    for ring in rings:
        path = points[first : first + len(ring)].reshape(-1, 2)
        first += len(ring)
        sine, longitude = np.sin(np.radians(path[:, 0])), np.radians(path[:, 1])
        zone = b * b / 2 * (sine / (1 - (e * sine) ** 2) + np.log((1 + e * sine) / (1 - e * sine)) / (2 * e))
        zone -= zone[0]  # so that little is subtracted from much once only
        areas.append(abs(np.sum((np.roll(longitude, -1) - longitude) * (zone + np.roll(zone, -1)) / 2)))
    return np.array(areas)


def planar_areas(rings):
    def area(ring):
        x, y = (ring - ring[0]).T
        return abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2

    return np.array([area(ring) for ring in rings])


def judge_areas(numbers, kind):
    rings, told, at = [], [], 0
    while at < len(numbers):
        area, count = numbers[at], int(numbers[at + 1])
        told.append(area)
        rings.append(numbers[at + 2 : at + 2 + 2 * count].reshape(-1, 2))
        at += 2 + 2 * count
    truth = geodesic_areas(rings) if kind == "geographic" else planar_areas(rings)
    return {"rings": len(rings), "largest_share": float(np.max(np.abs(np.array(told) / truth - 1))), "km2": [float(np.min(truth)) / 1e6, float(np.max(truth)) / 1e6]}


FINE = 4  # places in a sample's width, at whose middles heights are summed


def judge_volume(numbers, before, after):
    west, east, south, north, told = numbers
    first, last = Raster(before), Raster(after)
    columns, rows = (int(np.ceil(abs(side / step))) * FINE for side, step in ((east - west, last.dx), (north - south, last.dy)))
    x, y = west + (np.arange(columns) + 0.5) * (east - west) / columns, south + (np.arange(rows) + 0.5) * (north - south) / rows
    gained = last.at(*np.meshgrid(x, y)) - first.at(*np.meshgrid(x, y))
    truth = float(np.mean(gained)) * (east - west) * (north - south)
    return {"told_m3": float(told), "raster_m3": truth, "share": float(told) / truth - 1, "hectares": (east - west) * (north - south) / 1e4}


JUDGES = {"extent": judge_extent, "profiles": judge_profiles, "areas": judge_areas, "volume": judge_volume}

if __name__ == "__main__":
    kind, file, *rest = sys.argv[1:]
    print(json.dumps(JUDGES[kind](np.fromfile(file, np.float64), *rest)))
