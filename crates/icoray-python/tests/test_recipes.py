"""The blocks of Python of docs/src/python.md: in order, and those for ComIn and Ascent with stand-ins of these."""

from __future__ import annotations

import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest
import recipes
from conftest import PATIENCE, png_pixels

import icoray

PAGE = pathlib.Path(__file__).parents[3] / "docs/src/python.md"
MPIRUN = shutil.which("mpirun") or shutil.which("mpiexec")
STEPS = 3


def blocks() -> list[str]:
    """The blocks of Python of the page."""
    return [part.split("\n```", 1)[0] + "\n" for part in PAGE.read_text().split("```python\n")[1:]]


def is_recipe(block: str) -> bool:
    return "mpi4py" in block


def recipe(part: str) -> str:
    """The recipe with this part."""
    (found,) = (block for block in blocks() if is_recipe(block) and part in block)
    return found


def run(name: str, script: str, ranks: int, directory: pathlib.Path) -> list[np.ndarray]:
    """The pictures that a recipe draws in its stand-in."""
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    pytest.importorskip("xarray", reason="xarray is not installed")
    if MPIRUN is None:
        pytest.skip("no mpirun on the path")
    path = directory / "pictures.py"
    path.write_text(script)
    version = subprocess.run([MPIRUN, "--version"], capture_output=True, text=True).stdout
    options = ["--allow-run-as-root", "--oversubscribe"] if "Open MPI" in version or "OpenRTE" in version else []
    program = pathlib.Path(__file__).with_name("recipes.py")
    command = [MPIRUN, *options, "-n", str(ranks), sys.executable, str(program), name, str(path), str(directory)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0 and done.stdout.count("rank ") == ranks, done.stdout + done.stderr
    assert len((directory / "pictures/report.csv").read_text().splitlines()) == 1 + STEPS
    return [png_pixels(directory / f"pictures/{step}.png") for step in range(STEPS)]


def whole(name: str) -> list[np.ndarray]:
    """The pictures of the whole grid and field, without the recipe."""
    grid = icoray.Grid.from_triangles(recipes.LON, recipes.LAT, recipes.TRIANGLES)
    half_levels, full_levels = np.linspace(15e3, 0, recipes.LAYERS + 1), np.linspace(1e3, 15e3, recipes.LAYERS)
    is_comin = name == "comin"
    heights, location = (half_levels, "corner") if is_comin else (full_levels, "cell")
    corners = recipes.ICOSAHEDRAL.lon_corner_rad, recipes.ICOSAHEDRAL.lat_corner_rad
    places = corners if is_comin else (recipes.LON, recipes.LAT)
    layers, renderer = icoray.Layers.from_heights(heights, recipes.RADIUS), icoray.Renderer(1)
    scene = icoray.Scene(recipes.scene("q"))
    fields = [icoray.Field(recipes.wave(*places, step), location) for step in range(STEPS)]
    return [renderer.render(scene, grid, layers, field).to_rgba8() for field in fields]


def assert_close(pictures: list[np.ndarray], others: list[np.ndarray]) -> None:
    """Within the tolerance, 1e-3: but few pixels differ by more than one step of 8 bits in sRGB."""
    for picture, other in zip(pictures, others, strict=True):
        assert picture.std() > 20
        difference = np.abs(picture.astype(int) - other)
        assert (difference > 1).mean() < 1e-3 and difference.max() <= 8


@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize(("name", "part"), [("comin", "import itertools, comin"), ("ascent", "ascent_data()")])
def test_recipes_draw_the_picture_of_the_whole(name, part, ranks, tmp_path):
    assert_close(run(name, recipe(part), ranks, tmp_path), whole(name))


def test_one_rank_of_icon_lends_its_memory(tmp_path):
    call, check = "context.execute(step, date=comin.current_get_datetime())", 'context.report()["bytes_copied"] == 0'
    script = recipe("import itertools, comin")
    assert call in script
    script = script.replace(call, f"{call}\n        assert {check}")
    assert_close(run("comin", script, 1, tmp_path), whole("comin"))


def test_the_other_blocks_run_in_order(tmp_path, monkeypatch):
    pytest.importorskip("xarray", reason="xarray is not installed")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks():
        if not is_recipe(block):
            exec(compile(block, str(PAGE), "exec"), names)
    assert png_pixels(tmp_path / "theta.png").shape == (240, 320, 4)
    assert len(list((tmp_path / "pictures").glob("*.png"))) == STEPS
    assert [image.width for image in names["images"]] == [160] * 2  # type: ignore[attr-defined]
