"""Writes land-SCALE.bin and borders-SCALE.bin, of 110m and 50m, from the files of `npm pack world-atlas@2.0.2`

    python outlines.py land-SCALE.json > land-SCALE.bin
    python outlines.py countries-SCALE.json > borders-SCALE.bin

The files of world-atlas are TopoJSON of Natural Earth's land and countries. Those written here have coast lines, and lines
between two countries, as runs of points: the number of points (u16), then longitude and latitude of each (i16, in 1/180
degree), all little-endian. Lines are straight in longitude and latitude and end at longitudes 180 and -180 where they
cross them; coast lines have land on one side. Edges along these longitudes, which cut islands in two, are left out: no
coast or border runs there.
"""

import json
import struct
import sys

UNITS = 180


def arcs_of(topology):
    scale, shift = topology["transform"]["scale"], topology["transform"]["translate"]
    for arc in topology["arcs"]:
        x = y = 0
        points = []
        for dx, dy in arc:
            x, y = x + dx, y + dy
            points.append((x * scale[0] + shift[0], y * scale[1] + shift[1]))
        yield points


def number_rings_of(geometry):
    """The rings of a geometry, each as the numbers of its arcs; ~k is arc k from its end to its start."""
    polygons = geometry["arcs"] if geometry["type"] == "MultiPolygon" else [geometry["arcs"]]
    return [ring for polygon in polygons for ring in polygon]


def coasts_of(topology):
    arcs = list(arcs_of(topology))
    for geometry in topology["objects"]["land"]["geometries"]:
        for ring in number_rings_of(geometry):
            points = []
            for number in ring:
                arc = arcs[number] if number >= 0 else arcs[~number][::-1]
                points += arc[1:] if points else arc
            yield points


def borders_of(topology):
    """The arcs that two countries share."""
    countries = {}
    for country, geometry in enumerate(topology["objects"]["countries"]["geometries"]):
        for number in (number for ring in number_rings_of(geometry) for number in ring):
            countries.setdefault(max(number, ~number), set()).add(country)
    yield from (points for k, points in enumerate(arcs_of(topology)) if len(countries.get(k, ())) == 2)


def runs_of(ring):
    """The parts of a line, each within longitudes -180 to 180."""
    run = []
    for (lon, lat), (next_lon, next_lat) in zip(ring, ring[1:]):
        if abs(lon) == abs(next_lon) == 180:
            yield run
            run = []
            continue
        side = 180 if lon > 0 else -180
        if abs(lon) == 180:
            lon = side = 180 if next_lon > 0 else -180
        if abs(next_lon) == 180:
            next_lon = side
        if not run or run[-1] != (lon, lat):
            yield run
            run = [(lon, lat)]
        if abs(next_lon - lon) < 180:
            run.append((next_lon, next_lat))
            continue
        beyond = next_lon + 2 * side
        at = lat + (next_lat - lat) * (side - lon) / (beyond - lon)
        yield run + [(side, at)]
        run = [(-side, at), (next_lon, next_lat)]
    yield run


with open(sys.argv[1]) as file:
    topology = json.load(file)
lines = coasts_of(topology) if "countries" not in topology["objects"] else borders_of(topology)
for run in (run for line in lines for run in runs_of(line)):
    points = [(round(UNITS * lon), round(UNITS * lat)) for lon, lat in run]
    points = [point for i, point in enumerate(points) if i == 0 or point != points[i - 1]]
    if len(points) > 1:
        sys.stdout.buffer.write(struct.pack("<H", len(points)))
        for point in points:
            sys.stdout.buffer.write(struct.pack("<hh", *point))
