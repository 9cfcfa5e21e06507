"""Pictures of datasets of xarray and uxarray."""

from __future__ import annotations

import inspect
import json
import os
import pathlib
import re
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


def test_values_that_are_not_in_place_are_reported(mpas: Any):
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


def test_files_of_a_run_are_one_dataset(tmp_path: pathlib.Path):
    whole = icoray.sample()
    tables = [name for name in whole.variables if "Time" not in whole[name].dims]
    for time, name in enumerate(["history.1.nc", "history.2.nc"]):
        whole.drop_vars(tables).isel(Time=[time]).to_netcdf(tmp_path / name)
    whole[tables].to_netcdf(tmp_path / "mesh.nc")
    expected = icoray.open(whole)
    files = [tmp_path / "history.2.nc", str(tmp_path / "history.1.nc")]
    for data in [str(tmp_path / "history.*.nc"), tmp_path / "history.*.nc", files, [xarray.open_dataset(f) for f in files]]:
        opened = icoray.open(data, mesh=tmp_path / "mesh.nc")
        assert opened.times == expected.times and len(opened.times) == 2
        for time in (0, 1):
            image = opened.render("theta", time=time, **LOOK)
            assert same(image, expected.render("theta", time=time, **LOOK))
    with pytest.raises(ValueError, match=r"no file fits '.*none\.\*\.nc', expected a pattern"):
        icoray.open(str(tmp_path / "none.*.nc"))
    with pytest.raises(ValueError, match="expected one with fields"):
        icoray.open([])


def test_2d_fields_are_surfaces(mpas: Any):
    image = icoray.render(mpas, "surface_pressure", time=0, **LOOK)
    assert image.notes["field"] == "surface_pressure" and image.report["bytes_copied"] == 0
    assert image.pixels[40, 48, 3] == 1


def test_conditions_and_whole_numbers_are_fields(mpas: Any):
    field = mpas.theta.isel(nVertLevels=0)
    for array, ends in (
        (field > 300, (0, 1)),
        ((field > 300).isel(Time=0).astype("int8"), (0, 1)),
        (field.round().astype("uint16"), (int(field[-1].round().min()), int(field[-1].round().max()))),
    ):
        report = icoray.render(array, mesh=mpas, **LOOK).report
        assert (report["value_min"], report["value_max"]) == ends, array.dtype


def test_times_have_any_name(mpas: Any):
    times = np.array(["2003-01-01T06", "2003-01-02T06", "2003-01-03T06"], "datetime64[ns]")
    renamed = mpas.drop_vars("xtime").rename(Time="t").assign_coords(t=times)
    expected = icoray.render(mpas, "theta", time="2003-01-02", **LOOK)
    for dims in (("t", "nCells", "nVertLevels"), ("nCells", "t", "nVertLevels")):
        dataset = icoray.open(renamed.assign(theta=renamed.theta.transpose(*dims)))
        assert dataset.times == icoray.open(mpas).times and dataset.fields["theta"]["time_dependent"]
        assert same(dataset.render("theta", time="2003-01-02", **LOOK), expected)


def test_options_give_facts_that_a_dataset_lacks(mpas: Any):
    theta = mpas.theta.where(mpas.theta > 300, -999)
    several = mpas.drop_vars("zgrid").assign(theta=theta.expand_dims(member=2))
    dataset = icoray.open(several, at={"member": 1}, heights=(0, 3e3), radius=1e6, missing=[-999])
    assert dataset.layer_heights("theta") == [0, 1e3, 2e3, 3e3] and dataset.sphere_radius_m == 1e6
    report = dataset.render("theta", **LOOK).report
    assert report["missing_values"] == int((theta[-1] == -999).sum()) and report["value_min"] > 300
    with pytest.raises(icoray.ArgumentError, match="member has 2 entries"):
        icoray.open(several, at={"member": 2})
    with pytest.raises(icoray.FieldError, match="`at` picks an entry"):
        icoray.open(several).render("theta", **LOOK)
    with pytest.raises(TypeError, match="heigths"):
        icoray.open(several, heigths=(0, 1))


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
        ({"time": "yesterday"}, icoray.ArgumentError, ["yesterday", "expected a number from 0", "a date such as"]),
        ({"layers": "3"}, icoray.ArgumentError, ["layers: '3'", "(0, 20)"]),
        ({"layers": (0, 9)}, icoray.ArgumentError, ["0..9", "of the 4 layers of theta"]),
        ({"field": "theta", "colormap": "nomap"}, icoray.Error, ["nomap"]),
        ({"field": "theta", "surface": "up"}, icoray.ArgumentError, ["surface: 'up'"]),
        ({"field": "surface_pressure", "isosurface": 1e5}, icoray.ArgumentError, ["2D field, expected"]),
        ({"field": "theta", "isosurface": 300, "cmap": "vik"}, icoray.ArgumentError, ["colormap", "isosurfaces="]),
        ({"field": "theta", "size": 7}, icoray.ArgumentError, ["size: 7", "(width, height)"]),
        ({"field": "theta", "camra": {}}, TypeError, ["unexpected keyword argument 'camra'", "did you mean 'camera'"]),
        ({"field": "theta", "levels": 3}, TypeError, ["'levels'", "did you mean 'level'"]),
        ({"field": "theta", "every": 2}, TypeError, ["'every'"]),
        ({"field": "theta", "image": {"background": "white"}}, icoray.SceneError, ["a key of the scene itself"]),
        ({"field": "theta", "vmin": 3}, icoray.ArgumentError, ["vmin", "expected vmin and vmax together"]),
        ({"field": "theta", "cmap": "vik", "colormap": "vik"}, icoray.ArgumentError, ["no cmap beside colormap"]),
        ({"field": "theta", "progress": 3}, icoray.ArgumentError, ["progress: 3", "a function of two numbers"]),
        ({"field": "theta", "exaggeration": -1}, icoray.ArgumentError, ["exaggeration -1", "from 1e-6 to 1e6"]),
    ],
)
def test_refusals_name_the_argument(mpas: Any, arguments: dict[str, Any], kind: type[Exception], words: list[str]):
    with pytest.raises(kind) as refused:
        icoray.render(mpas, **arguments)
    assert all(word in str(refused.value) for word in words), refused.value


WRONG: list[dict[str, Any]] = [
    {"field": 3},
    {"size": (-1, 2)},
    {"size": (1.5, 2)},
    {"size": (0, 2)},
    {"lon": "a"},
    {"lon": 400},
    {"samples": -1},
    {"samples": 100},
    {"samples": 2**70},
    {"range": ("a", 1)},
    {"range": (2, 1)},
    {"colormap": 3},
    {"time": 9},
    {"time": 1.5},
    {"time": (0, 1)},
    {"time": "1999"},
    {"layers": 99},
    {"layers": [0, 1]},
    {"surface": 99},
    {"surface": 2**70},
    {"transfer": 3},
    {"transfer": {"map": 3}},
    {"transfer": {"rnge": [0, 1]}},
    {"surfaces": {"layer": 0}},
    {"surfaces": [3]},
    {"isosurfaces": [{"value": "x"}]},
    {"light": "headlight"},
    {"core": 3},
    {"labels": {"title": 3}},
    {"antialias": "yes"},
    {"camera": {"lon": 1, "eye": [3, 0, 0]}},
    {"camera": {"eye": [3, 0]}},
    {"opacity": [[1]]},
    {"backend": "gpuu"},
    {"view": 3},
    {"view": "near"},
    {"scene": "field = 'theta'", "samples": "a"},
    {"scene": "field = 'theta'", "lon": 1000},
    {"scene": "field = 'theta'", "colormap": "vik"},
    {"scene": 3},
    {"derive": [{"name": 3}]},
]
# Types of Rust, lines of generated text, options of the command and names of C.
FOREIGN = re.compile(r"struct |Raw|\b[iuf](16|32|64)\b|usize|out of range integral|line \d|(^|\s)--\w|\d\.\.|icoray_")


@pytest.mark.parametrize("arguments", WRONG, ids=str)
def test_refusals_are_those_of_python(mpas: Any, arguments: dict[str, Any]):
    with pytest.raises(icoray.Error) as refused:
        icoray.render(mpas, **{"field": "theta", "size": (40, 30), **arguments})
    assert not FOREIGN.search(str(refused.value)), refused.value
    named = [name for name in arguments if name in str(refused.value)]
    assert named or arguments.keys() <= {"lon", "colormap", "size", "range"}, refused.value


def test_refusals_of_objects_are_those_of_python(mesh: icoray.Grid, mpas: Any, tmp_path: pathlib.Path):
    layers = icoray.Layers.from_heights([0.0, 1e3], 6.371e6)
    context = icoray.Context(tmp_path, "field = 'q'")
    for wrong, words in [
        (lambda: icoray.Scene(tolerance="a"), "key tolerance: .*expected a number"),
        (lambda: icoray.Scene("field = 'q'", image={"width": "x"}), "key image.width: .*expected an integer"),
        (lambda: icoray.Scene("field = 'q'").replace(camera=3), "key camera: .*expected a table"),
        (lambda: icoray.Scene(size=(-1, 3)), "size: "),
        (lambda: icoray.Scene("field = 3"), "field = 3"),
        (lambda: icoray.Renderer(-1), "threads: -1, expected 0 to 4096"),
        (lambda: icoray.Grid.icosahedral(-1), "level: -1, expected 0 to 12"),
        (lambda: icoray.view(mpas, "theta", port=-1), "port: -1, expected 0 to 65535"),
        (lambda: icoray.view(mpas, "theta", threads=-1), "threads: -1"),
        (lambda: icoray.Context(threads=-1), "^threads: -1, expected"),
        (lambda: context.execute(0), "execute was called before a grid was set; call grid_set first"),
        (lambda: context.part_set(np.arange(3)), "grid"),
        (lambda: context.layers_set(layers) or context.heights_set(np.zeros((3, 2))), "grid"),
    ]:
        with pytest.raises(icoray.Error, match=words) as refused:
            wrong()
        # Its own text has lines.
        message = str(refused.value).replace("line 1 (field = 3)", "")
        assert not FOREIGN.search(message), message
    context.close()


def test_an_isosurface_is_all_that_is_shown(mpas: Any):
    scene = icoray.open(mpas).scene("theta", isosurface=300, **LOOK).to_toml()
    assert "[[isosurfaces]]" in scene and "value = 300" in scene and "[transfer]" not in scene


def test_times_are_animated_in_one_scene(mpas: Any, tmp_path: pathlib.Path):
    pillow = pytest.importorskip("PIL.Image", reason="pillow is not installed")
    dataset = icoray.open(mpas)
    path = tmp_path / "film.png"
    dataset.animate(path, "theta", times=[1, 0], fps=4, **LOOK)
    film, scene = pillow.open(path), dataset.scene("theta", **LOOK)
    assert (film.n_frames, film.info["duration"]) == (2, 250)
    for frame, time in enumerate([1, 0]):
        film.seek(frame)
        dataset.render(scene=scene, time=time).save(tmp_path / "one.png")
        assert (np.asarray(film) == np.asarray(pillow.open(tmp_path / "one.png"))).all()
    with pytest.raises(icoray.ArgumentError, match=r"\.png, \.mp4 or \.gif"):
        dataset.animate(tmp_path / "film.jpg", "theta", **LOOK)
    with pytest.raises(TypeError, match="fsp"):
        dataset.animate(path, "theta", fsp=4)


def test_names_of_matplotlib_and_xarray_are_understood(mpas: Any):
    own = icoray.render(mpas, "theta", surface=1, colormap="plasma", range=(290, 310), **LOOK)
    theirs = icoray.render(mpas, "theta", level=1, cmap="plasma", vmin=290, vmax=310, **LOOK)
    assert same(own, theirs) and not same(own, icoray.render(mpas, "theta", surface=1, **LOOK))


def test_arguments_are_parameters(mpas: Any):
    for function in (icoray.render, icoray.view, icoray.Dataset.scene, icoray.Dataset.render, icoray.Dataset.view):
        parameters = inspect.signature(function).parameters
        assert {"time", "cmap", "lon", "transfer", "background"} <= parameters.keys()
        assert all(parameter.kind is not parameter.VAR_KEYWORD for parameter in parameters.values())
    # None is an argument that is not given.
    given = dict.fromkeys(inspect.signature(icoray.Dataset.scene).parameters.keys() - {"self", "field", "size"})
    assert icoray.open(mpas).scene("theta", **LOOK) == icoray.open(mpas).scene("theta", **{**given, **LOOK})


def test_notebooks_complete_arguments(mpas: Any):
    completer = pytest.importorskip("IPython.core.completer", reason="IPython is not installed")
    ipython = completer.IPCompleter(namespace={"icoray": icoray, "ds": icoray.open(mpas)}, use_jedi=False)
    for call in ("icoray.render(ds, 'theta', tr", "ds.render('theta', tr"):
        _, found = ipython.complete(line_buffer=call, cursor_pos=len(call))
        assert "transfer=" in found, found


def test_a_notebook_shows_the_fields_of_a_dataset(mpas: Any):
    mpas.theta.attrs["long_name"] = "<script>"
    shown = icoray.open(mpas)._repr_html_()
    assert "<script>" not in shown and "<td>&lt;script&gt;</td>" in shown
    rows = [row.split("</td>")[0] for row in shown.split("<tr><td>")[1:]]
    assert rows[0] == "theta" and sorted(rows) == sorted(icoray.open(mpas).fields)


def test_a_wrong_table_names_row_and_value(mpas: Any, mesh: icoray.Grid):
    mpas.cellsOnVertex.values[7, 1] = 100_000
    with pytest.raises(icoray.GridError) as refused:
        icoray.open(mpas)
    assert "cellsOnVertex" in str(refused.value) and "(2, 8)" in str(refused.value), refused.value
    assert "100000, expected 1 to 642" in str(refused.value), refused.value
    with pytest.raises(icoray.GridError, match="no mesh is known.*give that file as `mesh`"):
        icoray.open(mpas[["xtime"]])
    with pytest.raises(icoray.GridError, match="give that file as `mesh`"):
        icoray.open(mpas.theta)
    with pytest.raises(icoray.LayersError, match="no heights for .*give that file as `mesh`"):
        icoray.open(datasets.mpas(mesh).drop_vars("zgrid")).render("theta")
    for wrong in ((17, ()), (mpas, 17), (mpas, [17])):
        with pytest.raises(icoray.ArgumentError, match="an? int, expected a dataset of xarray"):
            icoray.open(*wrong)


def test_progress_is_reported(mpas: Any):
    reports: list[tuple[int, int]] = []
    # Drawn slowly enough for a report of progress.
    icoray.render(mpas, "theta", size=(1200, 900), samples=16, progress=lambda done, of: reports.append((done, of)))
    assert all(0 <= done <= of for done, of in reports)


def test_a_page_is_served_until_it_is_closed(mpas: Any):
    with icoray.view(mpas, "theta", **LOOK) as view:
        address = view.address.split("#")[0]
        with urllib.request.urlopen(address) as page:
            assert b"icoray" in page.read()
            assert "frame-ancestors 'self' http://localhost:*" in page.headers["Content-Security-Policy"]
        assert view.scene.field == "theta"
        assert view.address in view._repr_html_()
        server, token = view.address.split("#")
        asked = urllib.request.Request(f"{server}api/scene", headers={"Authorization": f"Bearer {token}"})
        with urllib.request.urlopen(asked) as scene:
            assert json.load(scene)["command"] == 'image = icoray.render(data, scene="scene.toml", time=2)'
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(address, timeout=5)


def test_a_page_keeps_the_size_that_a_call_gives(mpas: Any):
    scene = icoray.open(mpas).scene("theta", lon=10)
    for given, width in [({"size": (96, 80)}, 96), ({"size": (96, 80), "scene": scene}, 96), ({"lon": 10}, 300)]:
        with icoray.view(mpas, "theta", **given) as view:
            server, token = view.address.split("#")
            headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
            body = json.dumps({"size": [300, 200]}).encode()
            urllib.request.urlopen(urllib.request.Request(f"{server}api/change", body, headers)).close()
            assert view.scene.width == width, given
            assert not view.scene.to_toml().startswith("#"), "the comment is about a suggestion at one time"


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


def ugrid(mesh: icoray.Grid, path: pathlib.Path) -> None:
    """A file of triangles that counts nodes from 1, with values at nodes."""
    lon = ("node", np.degrees(mesh.lon_center_rad), {"standard_name": "longitude", "units": "degrees_east"})
    lat = ("node", np.degrees(mesh.lat_center_rad), {"standard_name": "latitude", "units": "degrees_north"})
    role = {"cf_role": "face_node_connectivity", "start_index": np.int32(1)}
    topology = {
        "cf_role": "mesh_topology",
        "topology_dimension": np.int32(2),
        "node_coordinates": "lon lat",
        "face_node_connectivity": "nodes",
    }
    values = np.cos(mesh.lat_center_rad) * np.sin(mesh.lon_center_rad)
    variables = {
        "mesh": ((), np.int32(0), topology),
        "lon": lon,
        "lat": lat,
        "nodes": (("face", "three"), mesh.corner_cell + 1, role),
        "sst": ("node", values, {"mesh": "mesh", "location": "node"}),
    }
    xarray.Dataset(variables).to_netcdf(path)


def test_uxarray_counts_from_0_whatever_the_file_does(uxarray: Any, mesh: icoray.Grid, tmp_path: pathlib.Path):
    path = tmp_path / "ugrid.nc"
    ugrid(mesh, path)
    dataset = uxarray.open_dataset(path, path)
    assert dataset.uxgrid.face_node_connectivity.values.min() == 0
    expected = icoray.render(path, "sst", **LOOK)
    assert np.abs(icoray.render(dataset, "sst", **LOOK).pixels - expected.pixels).max() < 1e-4
    assert list(icoray.open(path).fields) == ["sst"]


def test_columns_need_no_tables(mesh: icoray.Grid):
    columns = {
        "lon": ("ncol", np.degrees(mesh.lon_center_rad), {"units": "degrees_east"}),
        "lat": ("ncol", np.degrees(mesh.lat_center_rad), {"units": "degrees_north"}),
        "PS": ("ncol", np.sin(mesh.lat_center_rad)),
    }
    dataset = icoray.open(xarray.Dataset(columns))
    assert (dataset.convention, dataset.cells) == ("points", mesh.cells)
    assert "Delaunay triangles of the points" in icoray.render(xarray.Dataset(columns), "PS", **LOOK).notes["note"]


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
    assert (opened.convention, opened.cells, opened.corners) == ("UGRID", mesh.cells, mesh.corners)
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
