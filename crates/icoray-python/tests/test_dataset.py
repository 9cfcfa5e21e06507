"""Pictures of datasets of xarray and uxarray."""

from __future__ import annotations

import os
import pathlib
import subprocess
import urllib.error
import urllib.request
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import icoray
from conftest import data_file, png_pixels

xarray = pytest.importorskip("xarray", reason="xarray is not installed")
import datasets  # noqa: E402

LOOK: dict[str, Any] = {"size": (96, 80), "lon": 10, "lat": 20}


@pytest.fixture(scope="session")
def mesh() -> icoray.Grid:
    return datasets.grid()


@pytest.fixture
def mpas(mesh: icoray.Grid) -> Any:
    return datasets.mpas(mesh)


@pytest.fixture
def icon(mesh: icoray.Grid) -> Any:
    return datasets.icon(mesh)


@pytest.fixture
def uxarray() -> Iterator[Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield pytest.importorskip("uxarray", reason="uxarray is not installed")


def same(one: icoray.Image, other: icoray.Image) -> bool:
    return bool((one.pixels == other.pixels).all())


def test_control_characters_of_a_dataset_are_escaped(mpas: Any):
    mpas.theta.attrs.update(units="\x1b[31m\nK", long_name="\x9b2J")
    mpas.encoding["source"] = "a\x1b[2J.nc"
    dataset = icoray.open(mpas)
    notes = icoray.render(mpas, "theta", **LOOK).notes
    assert (notes["units"], notes["long name"]) == (r"\u{1b}[31m\nK", r"\u{9b}2J")
    with pytest.raises(icoray.Error) as raised:
        icoray.render(mpas, "\x1b[31m", **LOOK)
    assert r"\u{1b}[31m" in str(raised.value)
    assert all(text.isprintable() for text in (repr(dataset), str(raised.value), *notes.values()))


def test_a_picture_is_that_of_the_grid_layers_and_field(mpas: Any, mesh: icoray.Grid):
    image = icoray.render(mpas, "theta", time=1, **LOOK)
    scene = icoray.open(mpas).scene("theta", time=1, **LOOK)
    heights = datasets.HEIGHT_M
    layers = icoray.Layers.from_heights((heights[1:] + heights[:-1]) / 2, datasets.RADIUS_M)
    by_hand = icoray.Renderer().render(scene, mesh, layers, icoray.Field(mpas.theta.values[1]))
    assert np.abs(image.pixels - by_hand.pixels).max() < 1e-6
    assert image.report["bytes_copied"] == 0
    assert image.notes["date"] == "2003-01-02_06:00:00" and image.notes["units"] == "K"


def test_without_arguments_the_likeliest_field_is_drawn_at_the_last_time(mpas: Any):
    image = icoray.render(mpas)
    assert (image.notes["field"], image.notes["step"]) == ("theta", "2")
    assert image.error.max() <= 1e-3 and np.ptp(image.pixels[..., :3]) > 0.3


def test_changes_of_an_array_in_memory_are_seen(mpas: Any):
    opened = icoray.open(mpas)
    scene = opened.scene("theta", time=0, **LOOK)
    before = opened.render(time=0, scene=scene)
    mpas.theta.values[0] += 9
    after = opened.render(time=0, scene=scene)
    assert not same(before, after) and after.report["bytes_copied"] == 0


@pytest.mark.parametrize(
    "dims",
    [("Time", "nVertLevels", "nCells"), ("nCells", "Time", "nVertLevels"), ("nVertLevels", "nCells", "Time")],
)
def test_dimensions_may_come_in_any_order_without_a_copy(mpas: Any, dims: tuple[str, ...]):
    expected = icoray.render(mpas, "theta", time=2, **LOOK)
    mpas["theta"] = mpas.theta.transpose(*dims)
    image = icoray.render(mpas, "theta", time=2, **LOOK)
    assert same(image, expected) and image.report["bytes_copied"] == 0


def test_levels_may_go_down(icon: Any):
    expected = icoray.render(icon, "ta", time=0, **LOOK)
    image = icoray.render(icon.isel(height=slice(None, None, -1)), "ta", time=0, **LOOK)
    assert np.abs(image.pixels - expected.pixels).max() < 1e-5 and image.report["bytes_copied"] == 0


def test_what_is_not_in_place_is_told(mpas: Any):
    bytes_of_a_time = mpas.theta.values[0].nbytes
    scene = icoray.open(mpas).scene("theta", time=0, **LOOK)
    expected = icoray.render(mpas, scene=scene, time=0)
    for converted, count in [
        (mpas.theta.astype(">f4"), bytes_of_a_time),
        (mpas.theta.astype("float16"), bytes_of_a_time),
        (mpas.theta.chunk(Time=1) if _has_dask() else mpas.theta.astype(">f4"), bytes_of_a_time),
    ]:
        mpas["theta"] = converted
        image = icoray.render(mpas, scene=scene, time=0)
        assert image.report["bytes_copied"] == count, converted.dtype
        # A suggestion looks at the values too.
        assert icoray.render(mpas, "theta", time=0, **LOOK).report["bytes_copied"] == 2 * count
        if converted.dtype != np.float16:
            assert same(image, expected)


def _has_dask() -> bool:
    try:
        import dask.array  # noqa: F401
    except ImportError:
        return False
    return True


def test_missing_values_are_missing(mpas: Any):
    mpas.theta.values[0, :40] = np.nan
    image = icoray.render(mpas, "theta", time=0, **LOOK)
    assert image.report["missing_values"] == 40 * datasets.LAYERS
    mpas.theta.values[0, :40] = -9e33
    mpas.theta.attrs["_FillValue"] = np.float32(-9e33)
    marked = icoray.render(mpas, "theta", time=0, **LOOK)
    assert same(image, marked) and marked.report["bytes_copied"] == 0


def test_dry_layers_of_an_ocean_are_masked_in_a_copy(mpas: Any, mesh: icoray.Grid):
    mpas["maxLevelCell"] = ("nCells", np.full(mesh.cells, datasets.LAYERS, np.int32))
    mpas.maxLevelCell.values[:10] = 0
    before = mpas.theta.values.copy()
    image = icoray.render(mpas, "theta", time=0, **LOOK)
    assert image.report["missing_values"] == 10 * datasets.LAYERS
    assert image.report["bytes_copied"] >= before[0].nbytes
    assert (mpas.theta.values == before).all()


@pytest.mark.parametrize("time", [1, -2, "2003-01-02", "2003-01-02T06", np.datetime64("2003-01-02T06")])
def test_times_are_numbers_or_dates(mpas: Any, icon: Any, time: Any):
    for dataset, field in [(mpas, "theta"), (icon, "ta")]:
        assert icoray.render(dataset, field, time=time, **LOOK).notes["step"] == "1"


def test_a_dataset_of_one_time_has_its_date(icon: Any):
    image = icoray.render(icon.isel(time=2), "ta", **LOOK)
    assert image.notes["date"] == "2003-01-03_06:00:00"
    assert same(image, icoray.render(icon, "ta", time=2, **LOOK))


def test_dates_of_other_calendars(icon: Any):
    cftime = pytest.importorskip("cftime", reason="cftime is not installed")
    dates = [cftime.DatetimeNoLeap(2003, 3, day) for day in (1, 2, 3)]
    opened = icoray.open(icon.assign_coords(time=np.array(dates, object)))
    assert opened.times == ["2003-03-01_00:00:00", "2003-03-02_00:00:00", "2003-03-03_00:00:00"]


def test_a_triangle_of_icon_is_a_corner(icon: Any, mesh: icoray.Grid):
    opened = icoray.open(icon)
    assert (opened.convention, opened.cells, opened.corners) == ("ICON", mesh.cells, mesh.corners)
    assert opened.fields["ta"]["location"] == "corner"
    assert opened.layer_heights("ta") == list(datasets.HEIGHT_M[:4])
    assert opened.render("ta", **LOOK).report["bytes_copied"] == 0


def test_mesh_and_heights_may_be_in_other_datasets(mpas: Any):
    expected = icoray.render(mpas, "theta", time=0, **LOOK)
    fields = mpas[["theta", "xtime"]]
    without = mpas.drop_vars(["theta", "xtime", "vorticity", "surface_pressure"])
    assert same(icoray.render(fields, "theta", mesh=without, time=0, **LOOK), expected)
    halves = [without.drop_vars("zgrid"), without[["zgrid"]]]
    assert same(icoray.render(fields, "theta", mesh=halves, time=0, **LOOK), expected)
    assert same(icoray.render(mpas.theta, mesh=without, time=0, **LOOK), expected)


def test_2d_fields_are_surfaces(mpas: Any):
    image = icoray.render(mpas, "surface_pressure", time=0, **LOOK)
    assert image.notes["field"] == "surface_pressure" and image.report["bytes_copied"] == 0
    assert image.pixels[40, 48, 3] == 1


def test_layers_are_selected(mpas: Any):
    some = [icoray.render(mpas, "theta", layers=layers, **LOOK) for layers in (slice(1, 3), (1, 3), "1..3")]
    assert same(some[0], some[1]) and same(some[0], some[2])
    assert not same(some[0], icoray.render(mpas, "theta", **LOOK))


def test_scenes_take_keys_and_short_names(mpas: Any, tmp_path: pathlib.Path):
    scene = icoray.open(mpas).scene("theta", **LOOK)
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    as_given = icoray.render(mpas, scene=scene, time=0)
    for given in (path, str(path), scene.to_toml()):
        assert same(icoray.render(mpas, scene=given, time=0), as_given)
    moved = icoray.render(mpas, scene=scene, time=0, lon=80)
    assert not same(moved, as_given)
    assert same(moved, icoray.render(mpas, scene=scene, time=0, camera={"lon": 80}))
    assert icoray.render(mpas, scene=scene, size=(40, 30)).pixels.shape == (30, 40, 4)
    last = icoray.render(mpas, scene=scene, time=-1)
    assert same(icoray.render(mpas, scene=scene), last) and not same(last, as_given)
    assert icoray.render(mpas, "theta", samples=4, **LOOK).report["samples"] == 4


def test_a_scene_that_names_a_field_alone_is_the_suggestion(mpas: Any):
    size = {"size": (96, 80)}
    for field in ("theta", "vorticity", "surface_pressure"):
        assert same(icoray.render(mpas, scene=f"field = '{field}'", **size), icoray.render(mpas, field, **size))
    # A scene that shows another field gives it that one's look, and keeps camera and light.
    view = {"distance": 4, "exaggeration": 50, "light": {"kind": "none"}, **LOOK}
    saved = icoray.open(mpas).scene("theta", **view)
    other = icoray.render(mpas, "vorticity", scene=saved)
    assert same(other, icoray.render(mpas, "vorticity", **view))
    assert not same(other, icoray.render(mpas, scene=saved))


@pytest.mark.parametrize(
    ("arguments", "kind", "words"),
    [
        ({"field": "nothing"}, icoray.FieldError, ["there is no field nothing", "theta"]),
        ({"time": 3}, icoray.ArgumentError, ["time", "3"]),
        ({"time": "2003-01"}, icoray.ArgumentError, ["3 times, expected one"]),
        ({"time": "yesterday"}, icoray.ArgumentError, ["yesterday", "expected a number, a date"]),
        ({"layers": "3"}, icoray.ArgumentError, ["layers: 3", "0..20"]),
        ({"layers": (0, 9)}, icoray.ArgumentError, ["0..9", "of the 4 layers of theta"]),
        ({"field": "theta", "colormap": "nomap"}, icoray.Error, ["nomap"]),
        ({"field": "theta", "surface": "up"}, icoray.ArgumentError, ["surface: up"]),
        ({"field": "theta", "size": 7}, icoray.ArgumentError, ["size: 7"]),
        ({"field": "theta", "camra": {}}, icoray.SceneError, ["camra"]),
    ],
)
def test_refusals_name_the_argument(mpas: Any, arguments: dict[str, Any], kind: type[Exception], words: list[str]):
    with pytest.raises(kind) as refused:
        icoray.render(mpas, **arguments)
    assert all(word in str(refused.value) for word in words), refused.value


def test_a_wrong_table_names_row_and_value(mpas: Any):
    mpas.cellsOnVertex.values[7, 1] = 100_000
    with pytest.raises(icoray.GridError) as refused:
        icoray.open(mpas)
    assert "cellsOnVertex" in str(refused.value) and "(2, 8)" in str(refused.value), refused.value
    assert "100000, expected 1 to 642" in str(refused.value), refused.value
    with pytest.raises(icoray.GridError, match="no mesh is known"):
        icoray.open(mpas[["xtime"]])
    with pytest.raises(icoray.ArgumentError, match="expected a dataset of xarray"):
        icoray.open(17)


def test_progress_is_told(mpas: Any):
    told: list[tuple[int, int]] = []
    # Drawn slowly enough for it to be told at all.
    icoray.render(mpas, "theta", size=(1200, 900), samples=16, progress=lambda done, of: told.append((done, of)))
    assert all(0 <= done <= of for done, of in told)


def test_a_page_is_served_until_it_is_closed(mpas: Any):
    with icoray.view(mpas, "theta", **LOOK) as view:
        address = view.address.split("#")[0]
        with urllib.request.urlopen(address) as page:
            assert b"icoray" in page.read()
            assert "frame-ancestors 'self' http://localhost:*" in page.headers["Content-Security-Policy"]
        assert view.scene.field == "theta"
        assert view.address in view._repr_html_()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(address, timeout=5)


def test_uxarray_gives_the_picture_of_xarray(uxarray: Any, tmp_path: pathlib.Path):
    path = data_file("mpas_jw_10242.nc")
    dataset = uxarray.open_dataset(path, path)
    expected = icoray.render(xarray.open_dataset(path), "theta", time=2, **LOOK)
    image = icoray.render(dataset, "theta", time=2, **LOOK)
    # Its degrees are rounded.
    assert np.abs(image.pixels - expected.pixels).max() < 1e-4
    corners = icoray.render(dataset, "vorticity", time=2, **LOOK)
    assert corners.notes["field"] == "vorticity"
    # Fields alone, with heights elsewhere.
    alone = uxarray.open_dataset(path, path)[["theta"]]
    with pytest.raises(icoray.LayersError, match="zgrid"):
        icoray.render(alone, "theta", time=2, **LOOK)
    assert same(icoray.render(alone, "theta", mesh=path, time=2, **LOOK), image)


def test_uxarray_of_icon_has_triangles(uxarray: Any, icon: Any, mesh: icoray.Grid, tmp_path: pathlib.Path):
    grid = uxarray.Grid.from_topology(
        node_lon=np.degrees(mesh.lon_center_rad),
        node_lat=np.degrees(mesh.lat_center_rad),
        face_node_connectivity=np.asarray(mesh.corner_cell, np.int64),
        fill_value=np.iinfo(np.int64).min,
    )
    fields = icon[["ta"]].drop_vars(["clon", "clat", "clon_bnds", "clat_bnds"], errors="ignore")
    dataset = uxarray.UxDataset(fields.rename(ncells="n_face"), uxgrid=grid)
    opened = icoray.open(dataset)
    assert (opened.convention, opened.cells, opened.corners) == ("ICON", mesh.cells, mesh.corners)
    image = opened.render("ta", time=0, **LOOK)
    assert np.abs(image.pixels - icoray.render(icon, "ta", time=0, **LOOK).pixels).max() < 1e-3
    assert image.report["bytes_copied"] == 0


@pytest.mark.parametrize("name", ["mpas_jw_10242.nc", "psyplot_icon_test.nc"])
def test_real_files_are_drawn_in_three_lines(name: str, tmp_path: pathlib.Path):
    image = icoray.render(data_file(name))
    image.save(tmp_path / "picture.png")
    assert png_pixels(tmp_path / "picture.png").shape == (image.height, image.width, 4)
    assert image.error.max() < 2e-3


def test_the_picture_is_that_of_the_command(tmp_path: pathlib.Path):
    command = os.environ.get("ICORAY_COMMAND")
    if not command:
        pytest.skip("ICORAY_COMMAND does not name the command icoray")
    for name in ("mpas_jw_10242.nc", "psyplot_icon_test.nc"):
        path = data_file(name)
        subprocess.run([command, "render", path, "-o", tmp_path / "theirs.png", "--size", "200x150"], check=True)
        icoray.render(path, size=(200, 150)).save(tmp_path / "ours.png")
        assert (png_pixels(tmp_path / "ours.png") == png_pixels(tmp_path / "theirs.png")).all(), name
