"""Ranks of mpi4py against one process."""

from __future__ import annotations

import pathlib
import shutil
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from conftest import LAYERS, PATIENCE, SCENE, blob, png_pixels

import icoray

MPIRUN = shutil.which("mpirun") or shutil.which("mpiexec")


def run(mode: str, ranks: int, directory: pathlib.Path) -> list[pathlib.Path]:
    """The pictures of `ranks.py`."""
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    if MPIRUN is None:
        pytest.skip("no mpirun on the path")
    version = subprocess.run([MPIRUN, "--version"], capture_output=True, text=True).stdout
    options = ["--allow-run-as-root", "--oversubscribe"] if "Open MPI" in version or "OpenRTE" in version else []
    program = pathlib.Path(__file__).with_name("ranks.py")
    command = [MPIRUN, *options, "-n", str(ranks), sys.executable, str(program), mode, str(directory)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0 and done.stdout.count("rank ") == ranks, done.stdout + done.stderr
    return [directory / f"q_{step}.{'png' if mode == 'fragments' else 'exr'}" for step in range(3)]


def expected(path: pathlib.Path, step: int, location: str = "cell") -> None:
    """Writes the picture of one process at a step of `ranks.py`."""
    grid = icoray.Grid.icosahedral(3)
    layers = icoray.Layers.from_heights(np.linspace(1e3, 15e3, LAYERS), 6.371e6)
    places = {"cell": (grid.lon_center_rad, grid.lat_center_rad), "corner": (grid.lon_corner_rad, grid.lat_corner_rad)}
    lon, lat = places[location]
    wave = blob(lon + 0.4 * step, lat)
    renderer = icoray.Renderer(1)
    with icoray.Context(path.parent, SCENE + f'[output]\nfile = "{path.name}"\n') as context:
        context.grid_set(grid)
        context.layers_set(layers)
        context.field_set("q", wave, location)
        context.execute(step, 60.0 * step)
    if path.suffix == ".png":
        np.testing.assert_array_equal(png_pixels(path), renderer.render(SCENE, grid, layers, wave).to_rgba8())


@pytest.mark.parametrize("mode", ["whole", "columns", "corners", "parts", "fortran", "async", "failure"])
@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_ranks_draw_the_bits_of_one(mode, ranks, tmp_path):
    for step, picture in enumerate(run(mode, ranks, tmp_path)):
        expected(tmp_path / "one.exr", step, "corner" if mode == "corners" else "cell")
        assert picture.read_bytes() == (tmp_path / "one.exr").read_bytes(), "all floats, and the texts beside them"
        (tmp_path / "one.exr").unlink()


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_fragments_make_the_picture_of_the_whole(ranks, tmp_path):
    """To the tolerance: each rank draws its cells, and the fragments of rays are composed."""
    for step, picture in enumerate(run("fragments", ranks, tmp_path)):
        expected(tmp_path / "one.png", step)
        difference = png_pixels(picture).astype(int) - png_pixels(tmp_path / "one.png")
        # A thousandth in linear light may be 3 of 255 in the darkest colours.
        assert np.abs(difference).max() <= 3
        (tmp_path / "one.png").unlink()


def printed(program: str) -> str:
    """What a program prints. MPI is started in a process of its own: mpirun does not start in one that has it."""
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True)
    return done.stdout + done.stderr


def test_values_that_are_not_communicators_are_refused():
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    program = """
    import icoray
    try:
        icoray.Context(comm="world")
    except icoray.ArgumentError as error:
        print(error)
    """
    said = printed(program)
    if "cannot load MPI library" in said:
        pytest.skip("no MPI library")
    assert "expected a communicator" in said, said


def test_ranks_need_mpi4py():
    program = """
    import sys
    sys.modules["mpi4py"] = None
    import icoray
    try:
        icoray.Context(comm=0)
    except icoray.UnsupportedError as error:
        print(error)
    """
    said = printed(program)
    assert "comm= needs the package mpi4py" in said, said
