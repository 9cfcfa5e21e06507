"""Grid, layers, field and scene of the tests."""

from __future__ import annotations

import os
import pathlib
import struct
import sys
import zlib
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest

import icoray

sys.path.insert(0, os.path.dirname(__file__))

LAYERS = 6
# Seconds that a test waits for an event that always comes before it takes it for a hang.
PATIENCE = 900

SCENE = """
field = "q"
exaggeration = 50
core = "#3a4b5c"
image = { width = 96, height = 80 }
camera = { lon = 10, lat = 20, distance = 4, fov = 40 }
[transfer]
map = "viridis"
range = [0, 1]
opacity = [[0, 0.0], [1, 0.9]]
"""


@pytest.fixture(scope="session", autouse=True)
def mpi_files(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Files of Open MPI's own lie where no other launcher removes the place while one of these tests starts."""
    os.environ["OMPI_MCA_orte_tmpdir_base"] = str(tmp_path_factory.mktemp("mpi"))


@pytest.fixture(scope="session")
def grid() -> icoray.Grid:
    return icoray.Grid.icosahedral(3)


@pytest.fixture(scope="session")
def layers() -> icoray.Layers:
    return icoray.Layers.from_heights(np.linspace(1e3, 15e3, LAYERS), 6.371e6)


@pytest.fixture(scope="session")
def scene() -> icoray.Scene:
    return icoray.Scene(SCENE)


@pytest.fixture(scope="session")
def renderer() -> icoray.Renderer:
    return icoray.Renderer(2)


@pytest.fixture
def wave(grid: icoray.Grid) -> npt.NDArray[np.float64]:
    return blob(grid.lon_center_rad, grid.lat_center_rad)


def blob(lon: npt.NDArray[np.floating], lat: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """Values of shape (columns, layers)."""
    near = np.exp(4 * (np.cos(lat) * np.cos(lon - 0.3) - 1))
    return np.ascontiguousarray(near[:, None] * np.exp(-0.1 * np.arange(LAYERS)), dtype=float)


def png_pixels(path: pathlib.Path) -> npt.NDArray[np.uint8]:
    """The pixels of a PNG of 8-bit RGBA."""
    data, at, packed, size = path.read_bytes(), 8, b"", (0, 0)
    while at < len(data):
        (length,), kind = struct.unpack(">I", data[at : at + 4]), data[at + 4 : at + 8]
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            size = struct.unpack(">II", body[:8])
            assert body[8:10] == b"\x08\x06"
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    before, pixels = np.zeros((width, 4), int), np.zeros((height, width, 4), np.uint8)
    for y, row in enumerate(rows):
        line, left = row[1:].reshape(width, 4).astype(int), np.zeros(4, int)
        if row[0] in (0, 2):
            line = (line + (before if row[0] == 2 else 0)) % 256
        else:
            corner = np.zeros(4, int)
            for x in range(width):
                above = before[x]
                if row[0] == 1:
                    guess = left
                elif row[0] == 3:
                    guess = (left + above) // 2
                else:
                    p = left + above - corner
                    a, b, c = abs(p - left), abs(p - above), abs(p - corner)
                    guess = np.where((a <= b) & (a <= c), left, np.where(b <= c, above, corner))
                left = line[x] = (line[x] + guess) % 256
                corner = above
        before = line
        pixels[y] = line
    return pixels


def lacks(need: str, why: str) -> None:
    """Skips a test for want of something, unless ICORAY_REQUIRE names it."""
    required = os.environ.get("ICORAY_REQUIRE", "").split(",")
    if need in required or "all" in required:
        pytest.fail(f"ICORAY_REQUIRE names {need}: {why}")
    pytest.skip(why)


def data_file(name: str) -> str:
    """The path of a file of a model, beside the repository or where ICORAY_TEST_DATA says."""
    repository = pathlib.Path(__file__).resolve().parents[3]
    folder = pathlib.Path(os.environ.get("ICORAY_TEST_DATA", repository.parent / "shared" / "data"))
    if not (folder / name).is_file():
        lacks("data", f"no data: {name}")
    return str(folder / name)


@pytest.fixture
def without_preemption() -> Iterator[None]:
    """Python's lock changes hands only where it is released."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e3)
    yield
    sys.setswitchinterval(before)
