"""Contexts, against renderers and against what the C interface promises."""

from __future__ import annotations

import datetime
import gc
import logging
import pathlib
import sys

import numpy as np
import pytest
from conftest import LAYERS, SCENE, blob, png_pixels

import icoray

FILE = SCENE + '[output]\nfile = "{field}_{step}.png"\n'


@pytest.fixture
def context(tmp_path: pathlib.Path, grid, layers):
    with icoray.Context(tmp_path, FILE, threads=1) as context:
        context.grid_set(grid)
        context.layers_set(layers)
        yield context


def test_a_context_draws_the_pictures_of_a_renderer(context, tmp_path, renderer, grid, layers, wave):
    for step, array in enumerate((wave, wave.T.astype(np.float32), np.asfortranarray(wave))):
        context.field_set("q", array)
        context.execute(step, 60.0 * step)
        context.wait()
        expected = renderer.render(FILE, grid, layers, array)
        np.testing.assert_array_equal(png_pixels(tmp_path / f"q_{step}.png"), expected.to_rgba8())
        report = context.report()
        assert (report["step"], report["time_s"], report["bytes_copied"]) == (step, 60.0 * step, 0)
        assert report["rays"] == expected.report["rays"] and report["drawn_on"] == "cpu"
        assert report["error_max"] == expected.report["error_max"] and report["scheme"] == "alone"
    assert report["frames_written"] == 3
    lines = (tmp_path / "report.csv").read_text().splitlines()
    assert len(lines) == 4


def test_its_floats_are_the_renderers(context, tmp_path, renderer, grid, layers, wave):
    context.scene_text(FILE.replace(".png", ".exr"))
    context.field_set("q", icoray.Field(wave, units="K"))
    context.execute(0)
    context.wait()
    renderer.render(FILE, grid, layers, icoray.Field(wave, units="K")).save(tmp_path / "a.exr")
    assert (tmp_path / "q_0.exr").read_bytes() == (tmp_path / "a.exr").read_bytes()


def test_arrays_are_read_at_each_step_and_kept(context, tmp_path, wave):
    array = wave.copy()
    references = sys.getrefcount(array)
    context.field_set("q", array)
    assert sys.getrefcount(array) > references
    for step in range(2):
        context.execute(step)
        array *= 0.5
    context.field_set("q", wave)
    gc.collect()
    assert sys.getrefcount(array) == references, "it was replaced"
    context.execute(2)
    context.wait()
    pictures = [png_pixels(tmp_path / f"q_{step}.png") for step in range(3)]
    assert (pictures[0] != pictures[1]).any()
    np.testing.assert_array_equal(pictures[0], pictures[2])


def test_a_temporary_array_lives_as_long_as_the_context_reads_it(context, tmp_path, wave):
    context.field_set("q", wave * 0.5)
    gc.collect()
    trash = [np.full_like(wave, 7.0) for _ in range(100)]
    context.execute(0)
    del trash
    context.field_set("q", np.asarray(wave * 0.5))
    context.execute(1)
    context.wait()
    np.testing.assert_array_equal(png_pixels(tmp_path / "q_0.png"), png_pixels(tmp_path / "q_1.png"))


def test_copies_are_counted_with_their_frame(context, wave):
    masked = np.ma.masked_less(wave, 0.01)
    context.field_set("q", masked)
    context.execute(0)
    report = context.report()
    assert report["bytes_copied"] == wave.nbytes and report["missing_values"] == masked.mask.sum()
    context.execute(1)
    assert context.report()["bytes_copied"] == 0, "nothing was copied for this one"
    context.field_set("q", np.broadcast_to(np.linspace(0, 1, LAYERS), wave.shape))
    context.execute(2)
    assert context.report()["bytes_copied"] == wave.nbytes


def test_a_scene_asks_for_rendering_in_the_background(context, tmp_path, renderer, grid, layers, wave):
    array = wave.copy()
    context.field_set("q", array)
    # Another scene does not switch it off.
    for step, scene in enumerate(("async_render = true\n" + FILE, FILE)):
        context.scene_text(scene)
        context.execute(step)
        array *= 0.5
        context.wait()
        assert context.report()["bytes_copied"] == array.nbytes
    for step, factor in enumerate((1.0, 0.5)):
        expected = renderer.render(FILE, grid, layers, wave * factor).to_rgba8()
        np.testing.assert_array_equal(png_pixels(tmp_path / f"q_{step}.png"), expected)


def test_fields_that_the_model_lacks_are_named_once(context, caplog, wave):
    views = "".join(f'[[views]]\nname = "v{number}"\n' for number in range(5))
    context.field_set("q", wave)
    with caplog.at_level(logging.WARNING, "icoray"):
        context.scene_text(FILE.replace('field = "q"', 'field = "qq"').replace("{field}", "{view}") + views)
        assert len(caplog.records) == 1
        assert all(part in caplog.text for part in ('the scene reads ["qq"]', 'it has ["q"]'))
        caplog.clear()
        with pytest.raises(icoray.FieldError):
            context.execute(0)
    messages = [record.getMessage() for record in caplog.records]
    assert sum("was not given" in message for message in messages) == 1, messages
    assert sum("4 more pictures failed for the same reason" in message for message in messages) == 1, messages


def test_every_kind_of_array_is_understood(context, tmp_path, renderer, grid, layers, wave):
    column = np.ascontiguousarray(wave[:, 0])
    corner = np.cos(grid.lat_corner_rad)[:, None] * np.ones(LAYERS, np.float32)
    blocked = np.pad(wave, ((0, 30), (0, 0))).reshape(21, 32, LAYERS).transpose(0, 2, 1)
    arrays = {
        "value per column": icoray.Field(column),
        "corners": icoray.Field(corner, "corner"),
        "blocks": icoray.Field(np.ascontiguousarray(blocked)),
        "axis": icoray.Field(wave.T, layer_axis=0),
        "fill": icoray.Field(np.where(wave < 0.1, -1.0, wave), fill=-1.0),
    }
    for step, (name, field) in enumerate(arrays.items()):
        context.field_set("q", field)
        context.execute(step)
        context.wait()
        expected = renderer.render(FILE, grid, layers, field).to_rgba8()
        np.testing.assert_array_equal(png_pixels(tmp_path / f"q_{step}.png"), expected, name)
        assert context.report()["bytes_copied"] == 0


def test_a_2d_field_is_a_surface_where_the_scene_has_no_opacity(context, tmp_path, renderer, grid, layers, wave):
    column = np.ascontiguousarray(wave[:, 0])
    opacity = "opacity = [[0, 0.0], [1, 0.9]]\n"
    clear = "opacity = [[0, 0.0], [1, 0.0]]\n"
    assert opacity in FILE
    # With map and range alone the suggestion would be drawn.
    plain = FILE.replace(opacity, 'scale = "linear"\n')
    colours = 'transfer = { map = "viridis", range = [0, 1] }\n'
    surface = FILE.replace(opacity, clear) + f'[[surfaces]]\nlayer = 0\nfield = "q"\n{colours}'
    context.scene_text(plain)
    context.field_set("q", column)
    context.execute(0)
    context.wait()
    expected = renderer.render(surface, grid, layers, column).to_rgba8()
    np.testing.assert_array_equal(png_pixels(tmp_path / "q_0.png"), expected)
    np.testing.assert_array_equal(renderer.render(plain, grid, layers, column).to_rgba8(), expected)
    assert not np.array_equal(renderer.render(FILE, grid, layers, column).to_rgba8(), expected)


def test_native_heights_can_be_set_and_removed(context, tmp_path, renderer, grid, layers, wave):
    native = FILE + "".join(['\n[[lines]]\npattern = "graticule"\n'])
    native = 'heights = "native"\n' + native
    heights = np.asarray(layers.radius_m) - 6.371e6 + 2e3 * wave
    context.scene_text(native)
    context.field_set("q", wave)
    with pytest.raises(icoray.FieldError, match="heights_set"):
        context.execute(0)
    context.heights_set(heights)
    context.execute(1)
    context.wait()
    expected = renderer.render(native, grid, layers, wave, heights=heights).to_rgba8()
    np.testing.assert_array_equal(png_pixels(tmp_path / "q_1.png"), expected)
    # Heights at corners are averaged to cells.
    relief = 2e3 * blob(grid.lon_corner_rad, grid.lat_corner_rad)
    at_corners = np.asarray(layers.radius_m) - 6.371e6 + relief
    averaged = [at_corners[list(dict.fromkeys(corners))].mean(0) for corners in np.asarray(grid.cell_corner).tolist()]
    context.heights_set(at_corners, "corner")
    context.execute(3)
    context.wait()
    expected = renderer.render(native, grid, layers, wave, heights=np.array(averaged)).to_rgba8().astype(int)
    assert np.abs(png_pixels(tmp_path / "q_3.png") - expected).max() <= 1
    context.heights_set(None)
    with pytest.raises(icoray.FieldError):
        context.execute(2)


def test_wants_follows_the_schedule(context, wave):
    context.scene_text("every = 4\n" + FILE)
    assert [context.wants(step) for step in range(5)] == [True, False, False, False, True]
    assert context.wants(4, field="q") and not context.wants(4, 0.0, "t")
    context.field_set("q", wave)
    context.execute(0)
    context.execute(1)
    assert context.report()["frames_failed"] == 0


def test_dates_are_in_names(tmp_path, grid, layers, wave):
    with icoray.Context(tmp_path, SCENE, existing="overwrite") as context:
        context.grid_set(grid)
        context.layers_set(layers)
        context.field_set("q", wave, "cell")
        context.field_describe("q", "mixing ratio", "kg kg-1")
        for date in (
            "2026-11-24_06:00:00",
            datetime.datetime(2026, 11, 24, 7, 0, 0, 123),
            np.datetime64("2026-11-24T08:00:00.5"),
            datetime.date(2026, 11, 25),
            np.datetime64("2026-11-26"),
        ):
            context.execute(3, date=date)
    names = sorted(path.name for path in tmp_path.glob("*.png"))
    dates = ["2026-11-24_06", "2026-11-24_07", "2026-11-24_08", "2026-11-25_00", "2026-11-26_00"]
    assert names == [f"q_{date}.00.00_000003.png" for date in dates]
    assert b"mixing ratio" in (tmp_path / names[0]).read_bytes()


def test_a_scene_file_is_loaded(tmp_path, grid, layers, wave):
    path = tmp_path / "scene.toml"
    path.write_text(FILE)
    for number, scene in enumerate((path, str(path), icoray.Scene(path))):
        with icoray.Context(tmp_path / str(number), scene) as context:
            context.grid_set(grid)
            context.layers_set(layers)
            context.field_set("q", wave)
            context.execute(0)
        assert (tmp_path / str(number) / "q_0.png").is_file()


def test_async_rendering_copies_and_goes_on(tmp_path, renderer, grid, layers, wave):
    array = wave.copy()
    with icoray.Context(tmp_path, FILE, async_render=True) as context:
        context.grid_set(grid)
        context.layers_set(layers)
        context.field_set("q", array)
        context.execute(0)
        array[:] = 0
        context.wait()
        assert context.report()["bytes_copied"] == wave.nbytes
    expected = renderer.render(FILE, grid, layers, wave).to_rgba8()
    np.testing.assert_array_equal(png_pixels(tmp_path / "q_0.png"), expected)


def test_grids_and_layers_have_names(tmp_path, grid, layers, wave):
    with icoray.Context(tmp_path, FILE) as context:
        context.grid_set(icoray.Grid.icosahedral(1), "coarse")
        context.grid_set(grid, "fine")
        context.layers_set(layers, "half")
        context.field_set("q", wave, grid="fine", layers="half")
        context.execute(0)
        with pytest.raises(icoray.ArgumentError, match='named "none"'):
            context.field_set("q", wave, grid="none", layers="half")


def test_failures_have_their_class(tmp_path, context, grid, wave):
    cases = [
        (icoray.FieldError, r"an array of extents \[642, 3\]", lambda: context.field_set("q", wave[:, :3])),
        (icoray.SceneError, "line 1", lambda: context.scene_text("field = 1")),
        (icoray.FileError, "none.toml", lambda: context.scene_load(tmp_path / "none.toml")),
        (icoray.OrderError, "no frame has been rendered", context.report),
        (icoray.FieldError, '"q" was refused by field_set', lambda: context.execute(0)),
        (icoray.ArgumentError, "time_s", lambda: context.execute(0, float("nan"))),
        (icoray.ArgumentError, "date", lambda: context.execute(0, date="2026-11-24\0")),
    ]
    for kind, why, call in cases:
        with pytest.raises(kind, match=why):
            call()
    context.field_set("q", wave)
    context.execute(1)
    context.wait()
    with pytest.raises(icoray.ExistsError, match="q_1.png") as error:
        context.execute(1)
    assert isinstance(error.value, FileExistsError) and error.value.kind == "exists"
    for keys, why in (
        ({"existing": "maybe"}, r'existing: "maybe", expected one of \["keep", "overwrite"\]'),
        ({"threads": -1}, "threads: -1"),
        ({"writer_queue": 9999}, "writer_queue"),
    ):
        with pytest.raises(icoray.ArgumentError, match=why):
            icoray.Context(tmp_path, **keys)


def test_a_refused_array_is_named_where_it_is_missing(context, wave):
    with pytest.raises(icoray.FieldError, match="complex128"):
        context.field_set("q", wave + 1j)
    with pytest.raises(icoray.FieldError, match='field "q" was refused by field_set: .*complex128'):
        context.execute(0)


def test_calls_in_the_wrong_order_are_named(tmp_path, grid, layers, wave):
    with icoray.Context(tmp_path) as context:
        with pytest.raises(icoray.OrderError, match="grid"):
            context.field_set("q", wave)
        context.grid_set(grid)
        context.layers_set(layers)
        with pytest.raises(icoray.OrderError, match="scene"):
            context.execute(0)
    assert context.closed
    context.close()
    with pytest.raises(icoray.OrderError, match="the context is closed"):
        context.execute(0)


def test_the_log_is_pythons(tmp_path, caplog, grid, layers, wave):
    with caplog.at_level(logging.INFO, "icoray"), icoray.Context(tmp_path, FILE) as context:
        context.grid_set(grid)
        context.layers_set(layers)
        context.field_set("q", wave)
        context.execute(0)
        context.wait()
        with pytest.raises(icoray.SceneError):
            context.scene_text("field = 1")
    levels = {record.levelname: record.getMessage() for record in caplog.records if record.name == "icoray"}
    assert "q_0.png" in levels["INFO"] and "bad scene" in levels["WARNING"] and "DEBUG" not in levels


def test_a_context_that_is_not_closed_warns_and_closes(tmp_path, grid, layers, wave):
    context = icoray.Context(tmp_path, FILE)
    context.grid_set(grid)
    context.layers_set(layers)
    context.field_set("q", wave)
    context.execute(0)
    with pytest.warns(ResourceWarning, match="was not closed"):
        del context
        gc.collect()
    assert (tmp_path / "q_0.png").is_file()


def test_a_context_is_in_one_call_at_a_time(context, tmp_path, wave):
    """A handler of the log is called within calls."""
    kinds = []

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            for call in (context.wait, context.close):
                with pytest.raises(icoray.BusyError, match="has not returned yet") as error:
                    call()
                kinds.append(error.value.kind)

    handler, logger = Handler(), logging.getLogger("icoray")
    logger.addHandler(handler)
    try:
        with pytest.raises(icoray.SceneError):
            context.scene_text("field = 1")
    finally:
        logger.removeHandler(handler)
    assert kinds == ["busy", "busy"]
    context.field_set("q", wave)
    context.execute(0)
    context.wait()
    assert (tmp_path / "q_0.png").is_file()


def test_a_single_process_owns_every_cell(context, tmp_path, grid, wave):
    context.field_set("q", wave)
    context.execute(0)
    context.part_set(np.arange(grid.cells), is_owned=np.ones(grid.cells, bool))
    context.execute(1)
    context.wait()
    np.testing.assert_array_equal(png_pixels(tmp_path / "q_0.png"), png_pixels(tmp_path / "q_1.png"))
    with pytest.raises(icoray.ArgumentError, match="is_owned: 3 marks, expected 642"):
        context.part_set(np.arange(grid.cells), is_owned=[1, 1, 1])
