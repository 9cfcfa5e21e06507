"""Writes maps.txt: pip install matplotlib cmocean cmcrameri; python maps.py > maps.txt

For each map a few of its 256 entries, in 8 bits, between which straight lines in linear light stay within 2/255 of all
others, in linear light and in sRGB: from the start on, each line is as long as it can be.
"""

from importlib.metadata import version

import cmocean
import matplotlib
import numpy as np
from cmcrameri import cm as crameri

TOLERANCE = 2.0
SOURCES = {
    "matplotlib": (
        matplotlib.colormaps.get_cmap,
        "bone bwr coolwarm cubehelix gist_earth gnuplot2 gray hot seismic terrain",
    ),
    "cmocean": (
        lambda name: getattr(cmocean.cm, name),
        "algae amp balance curl deep delta dense diff haline ice matter oxy phase rain solar speed tarn tempo thermal topo"
        " turbid",
    ),
    "cmcrameri": (
        lambda name: getattr(crameri, name),
        "acton bam bamO bamako batlow batlowK batlowW berlin bilbao broc brocO buda bukavu cork corkO davos devon fes"
        " glasgow grayC hawaii imola lajolla lapaz lipari lisbon managua navia nuuk oleron oslo roma romaO tofino tokyo"
        " turku vanimo vik vikO",
    ),
}


def linear(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def encoded(light):
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def stops(colors, entries):
    light, rounded = linear(colors), linear(entries / 255)

    def off(first, last):
        along = np.linspace(0, 1, last - first + 1)[:, None]
        line = rounded[first] + along * (rounded[last] - rounded[first])
        true = slice(first, last + 1)
        return 255 * max(np.abs(line - light[true]).max(), np.abs(encoded(line) - colors[true]).max())

    found = [0]
    while found[-1] < 255:
        last = found[-1] + 1
        while last < 255 and off(found[-1], last + 1) <= TOLERANCE:
            last += 1
        found.append(last)
    return found


# Parts of maps, from one place to another, whose colours all stand out from dark ground.
BRIGHT = {"viridis": (0.47, 1.0), "plasma": (0.45, 1.0), "coolwarm": (0.08, 0.92)}


def part(name, ends):
    """256 colours between two places of a map, on lines between its entries."""
    entries = matplotlib.colormaps[name](np.arange(256))[:, :3]
    places = 255 * np.linspace(*ends, 256)
    return np.transpose([np.interp(places, np.arange(256), channel) for channel in entries.T])


def line(name, colors):
    entries = np.rint(colors * 255).astype(int)
    print(name, *("%d:%02x%02x%02x" % (i, *entries[i]) for i in stops(colors, entries)))


for package, (get, names) in SOURCES.items():
    print(f"# {package} {version(package)}")
    for name in names.split():
        line(name.lower(), get(name)(np.arange(256))[:, :3])
print("# parts of matplotlib's")
for name, ends in BRIGHT.items():
    line(f"{name}_bright", part(name, ends))
