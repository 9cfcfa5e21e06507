"""The scripts of examples/python."""

from __future__ import annotations

import itertools
import pathlib
import runpy
import sys

import numpy as np
import pytest
from conftest import data_file

import icoray

SCRIPT = pathlib.Path(__file__).parents[3] / "examples/python/first_picture.py"


def run(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch, *arguments: str) -> dict[str, np.ndarray]:
    """The pictures that the script draws in a folder, by their names."""
    pytest.importorskip("xarray", reason="xarray is not installed")
    pillow = pytest.importorskip("PIL.Image", reason="pillow is not installed")
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), *arguments])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    return {path.stem: np.asarray(pillow.open(path)) for path in (folder / "pictures").glob("*.png")}


def reddish(pixels: np.ndarray) -> np.ndarray:
    """Pixels with the colours of high values."""
    red, _, blue = np.moveaxis(pixels[..., :3].astype(int), -1, 0)
    return red > blue + 60


def test_first_picture_makes_its_own_dataset(tmp_path, monkeypatch):
    pictures = run(tmp_path, monkeypatch)
    assert set(pictures) == {"suggested", "scene", *(f"time_{time}" for time in range(4))}
    assert pictures["scene"].shape == (480, 640, 4)
    np.testing.assert_array_equal(pictures["scene"], pictures["time_0"])
    # Left of the colour bar, warm and cold air share the picture.
    warm = reddish(pictures["scene"][:, :500])
    cold = reddish(pictures["scene"][:, :500, 2::-1])
    assert 0.03 < warm.mean() < 0.3 and 0.03 < cold.mean() < 0.3, (warm.mean(), cold.mean())
    # The wave moves by 12 degrees of its 72 in each day.
    for before, after in itertools.pairwise(range(4)):
        moved = reddish(pictures[f"time_{before}"][:, :500]) != reddish(pictures[f"time_{after}"][:, :500])
        assert 0.8 < moved.sum() / warm.sum() < 1.4, (before, moved.sum(), warm.sum())
    assert icoray.Scene((tmp_path / "pictures/scene.toml").read_text()).to_toml()


def test_first_picture_of_a_file(tmp_path, monkeypatch):
    pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    pictures = run(tmp_path, monkeypatch, data_file("mpas_jw_10242.nc"), "theta")
    assert set(pictures) == {"suggested", "scene", *(f"time_{time}" for time in range(3))}
    assert all(pixels[..., :3].std() > 20 for pixels in pictures.values())
