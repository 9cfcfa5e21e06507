"""Grids over tables."""

from __future__ import annotations

import numpy as np
import pytest

import icoray

NAMES = ["lon_center_rad", "lat_center_rad", "lon_corner_rad", "lat_corner_rad"]
TABLES = ["cell_corner", "corner_cell", "corner_edge", "edge_corner"]


def tables(grid, dtype=np.int32, real=np.float64, base=0):
    reals = {name: getattr(grid, name).astype(real) for name in NAMES}
    return {"index_base": base, **reals, **{name: (getattr(grid, name) + base).astype(dtype) for name in TABLES}}


def test_an_icosahedral_grid_has_its_numbers(grid):
    assert (grid.cells, grid.corners, grid.edges) == (642, 1280, 1920)
    assert grid.corner_cell.shape == (1280, 3) and grid.cell_corner_count is None and grid.bytes_copied == 0
    assert not grid.corner_cell.flags.writeable
    with pytest.raises(icoray.ArgumentError, match="level: 13, expected 0 to 12"):
        icoray.Grid.icosahedral(13)


@pytest.mark.parametrize("base", [0, 1])
@pytest.mark.parametrize("dtype", [np.int32, np.int64])
def test_tables_are_borrowed(dtype, base, renderer, scene, grid, layers, wave):
    given = tables(grid, dtype, base=base)
    same = icoray.Grid(**given)
    assert same.bytes_copied == 0 and same.index_base == base
    for name in NAMES + TABLES:
        assert np.shares_memory(getattr(same, name), given[name]), name
    given = None
    expected = renderer.render(scene, grid, layers, wave).pixels
    np.testing.assert_array_equal(renderer.render(scene, same, layers, wave).pixels, expected)


def test_tables_of_other_layouts_are_copied_and_reported(renderer, scene, grid, layers, wave):
    given = tables(grid)
    given["corner_cell"] = np.ascontiguousarray(given["corner_cell"].T).T
    given["edge_corner"] = given["edge_corner"].astype(">i4")
    given["corner_edge"] = given["corner_edge"].astype(np.uint32)
    given["lat_center_rad"] = np.repeat(given["lat_center_rad"], 2)[::2]
    copied = icoray.Grid(**given)
    assert copied.bytes_copied == 1280 * 3 * 4 + 1920 * 2 * 4 + 1280 * 3 * 8 + 642 * 8
    expected = renderer.render(scene, grid, layers, wave).pixels
    np.testing.assert_array_equal(renderer.render(scene, copied, layers, wave).pixels, expected)


def test_wrong_tables_are_named(grid):
    given = tables(grid)
    given["corner_cell"][7, 1] = 642
    with pytest.raises(icoray.GridError, match=r"corner_cell\[7\]") as error:
        icoray.Grid(**given)
    assert error.value.kind == "grid" and isinstance(error.value, ValueError)
    for name, wrong, why in (
        ("corner_edge", grid.corner_edge.T, r"shape \[3, 1280\], expected \(1280, 3\); pass its transpose"),
        ("corner_edge", grid.corner_edge.astype(float), "an array of float64, expected whole numbers"),
        ("lat_center_rad", grid.lat_center_rad[:-1], r"lat_center_rad: an array of shape \[641\], expected \(642\)"),
        ("index_base", 2, "index_base"),
    ):
        with pytest.raises(icoray.Error, match=why):
            icoray.Grid(**{**tables(grid), name: wrong})
    with pytest.raises(TypeError, match="edge_corner"):
        icoray.Grid(**{name: table for name, table in tables(grid).items() if name != "edge_corner"})


def test_triangles_are_enough(renderer, scene, grid, layers, wave):
    expected = renderer.render(scene, grid, layers, wave)
    for triangles, base in ((grid.corner_cell, 0), (grid.corner_cell.astype(np.int64) + 1, 1)):
        made = icoray.Grid.from_triangles(grid.lon_center_rad, grid.lat_center_rad, triangles, index_base=base)
        assert (made.cells, made.corners, made.edges) == (642, 1280, 1920)
        turns = np.mod(made.lon_corner_rad - grid.lon_corner_rad + np.pi, 2 * np.pi) - np.pi
        assert np.abs(turns * np.cos(grid.lat_corner_rad)).max() < 1e-9
        assert np.abs(made.lat_corner_rad - grid.lat_corner_rad).max() < 1e-9
        image = renderer.render(scene, made, layers, wave)
        assert (np.abs(image.pixels - expected.pixels).max(2) <= image.error + expected.error).all()
    wrong = np.array(grid.corner_cell)
    wrong[3] = [1, 1, 2]
    with pytest.raises(icoray.GridError, match="triangle 3 has the points"):
        icoray.Grid.from_triangles(grid.lon_center_rad, grid.lat_center_rad, wrong)
    with pytest.raises(icoray.ArgumentError, match="expected both or none"):
        icoray.Grid.from_triangles(
            grid.lon_center_rad, grid.lat_center_rad, grid.corner_cell, lon_corner_rad=grid.lon_corner_rad
        )


def test_points_are_enough(renderer, scene, grid, layers, wave):
    expected = renderer.render(scene, grid, layers, wave)
    made = icoray.Grid.from_points(grid.lon_center_rad, grid.lat_center_rad)
    assert (made.cells, made.corners, made.edges) == (642, 1280, 1920)
    triangles = [{tuple(sorted(row)) for row in table} for table in (made.corner_cell, grid.corner_cell)]
    assert triangles[0] == triangles[1]
    image = renderer.render(scene, made, layers, wave)
    assert (np.abs(image.pixels - expected.pixels).max(2) <= image.error + expected.error).all()
    wrong = np.array(grid.lat_center_rad)
    wrong[3] = np.nan
    with pytest.raises(icoray.GridError, match=r"center\[3\]"):
        icoray.Grid.from_points(grid.lon_center_rad, wrong)
    with pytest.raises(icoray.GridError, match="look like degrees"):
        icoray.Grid.from_points(np.degrees(grid.lon_center_rad), np.degrees(grid.lat_center_rad))


def test_a_grid_may_have_holes(renderer, scene, grid, layers, wave):
    there = np.cos(grid.lat_corner_rad) * np.cos(grid.lon_corner_rad) > 0
    half = icoray.Grid.from_triangles(grid.lon_center_rad, grid.lat_center_rad, grid.corner_cell[there])
    image = renderer.render(scene, half, layers, wave)
    assert half.corners == there.sum() and image.report["rays"] > 0
