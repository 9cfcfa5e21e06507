"""Pictures against what they must be."""

from __future__ import annotations

import json
import pathlib
import sys
import types

import numpy as np
import pytest
from conftest import png_pixels

import icoray


def test_a_shell_of_constant_extinction_is_as_opaque_as_its_chord(renderer):
    """Through the middle of a hollow shell a ray has twice its thickness: alpha = 1 - (1 - a)**(2 h / unit)."""
    grid = icoray.Grid.icosahedral(5)
    layers = icoray.Layers.from_heights([0.0, 0.1, 0.2], 1.0)
    scene = icoray.Scene(
        field="one",
        core="transparent",
        background="transparent",
        size=(33, 33),
        camera={"lon": 0, "lat": 0, "distance": 5},
        transfer={"map": "viridis", "range": [0, 2], "opacity": [[0, 0.3], [2, 0.3]], "unit_length": 0.2},
        precision="f64",
        tolerance=1e-7,
    )
    image = renderer.render(scene, grid, layers, np.ones((grid.cells, 3)))
    assert image.pixels[16, 16, 3] == pytest.approx(1 - (1 - 0.3) ** 2, abs=5e-4)
    assert not image.pixels[0, 0].any() and image.report["error_is_bound"]
    assert float(image.error.max()) <= 1e-7


def test_pixels_differ_from_double_precision_by_no_more_than_their_errors(renderer, scene, grid, layers, wave):
    one, other = (renderer.render(s, grid, layers, wave) for s in (scene, scene.replace(precision="f64")))
    difference = np.abs(one.pixels - other.pixels).max(axis=2)
    assert (difference <= one.error + other.error + 1e-7).all() and one.error.max() > 0


def test_an_image_lends_its_memory(renderer, scene, grid, layers, wave):
    image = renderer.render(scene, grid, layers, wave)
    pixels, again = image.pixels, image.pixels
    assert (image.width, image.height, pixels.shape, image.error.shape) == (96, 80, (80, 96, 4), (80, 96))
    assert pixels.dtype == image.error.dtype == np.float32
    assert np.shares_memory(pixels, again)
    with pytest.raises(ValueError):
        pixels[0, 0, 0] = 1
    copy = pixels.copy()
    del image, again
    np.testing.assert_array_equal(pixels, copy, "the view keeps the picture")


def test_an_image_is_an_array_of_numpy(renderer, scene, grid, layers, wave):
    image = renderer.render(scene, grid, layers, wave)
    pixels = np.asarray(image)
    assert pixels.dtype == np.uint8 and np.ptp(pixels) > 100
    np.testing.assert_array_equal(pixels, image.to_rgba8())
    np.testing.assert_array_equal(np.asarray(image, dtype=float), image.to_rgba8().astype(float))
    with pytest.raises(icoray.ArgumentError, match="copy: False"):
        image.__array__(copy=False)


def test_matplotlib_shows_an_image(renderer, scene, grid, layers, wave):
    figure = pytest.importorskip("matplotlib.figure", reason="matplotlib is not installed")
    image = renderer.render(scene, grid, layers, wave)
    shown = figure.Figure().subplots().imshow(image)
    np.testing.assert_array_equal(shown.get_array(), image.to_rgba8())


def test_an_image_is_shown(renderer, scene, grid, layers, wave, monkeypatch, tmp_path: pathlib.Path):
    image = renderer.render(scene, grid, layers, wave)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setitem(sys.modules, "IPython", None)
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    image.show()
    (file,) = tmp_path.glob("icoray-*.png")
    assert opened == [file.as_uri()] and file.read_bytes() == image._repr_png_()
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    with pytest.raises(icoray.UnsupportedError, match="save writes it elsewhere"):
        image.show()
    # In a notebook its kernel shows it.
    shell, shown = types.SimpleNamespace(kernel=None), []
    display = types.SimpleNamespace(display=shown.append)
    notebook = types.SimpleNamespace(get_ipython=lambda: shell, display=display)
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    image.show()
    assert shown == [image]


def test_files_have_the_pixels(renderer, scene, grid, layers, wave, tmp_path: pathlib.Path):
    image = renderer.render(scene, grid, layers, wave)
    rgba = image.to_rgba8()
    image.save(tmp_path / "a.png")
    image.save(str(tmp_path / "a.exr"))
    image.error_map(tmp_path / "error.png")
    np.testing.assert_array_equal(png_pixels(tmp_path / "a.png"), rgba)
    assert (tmp_path / "a.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"
    assert (tmp_path / "error.png").is_file()
    assert image._repr_png_() == (tmp_path / "a.png").read_bytes()
    # sRGB of straight colours, where the picture is opaque.
    x, y = 48, 40
    linear = image.pixels[y, x, :3] / image.pixels[y, x, 3]
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert rgba[y, x, 3] == 255 and np.abs(rgba[y, x, :3] - 255 * srgb).max() <= 0.501
    with pytest.raises(icoray.ArgumentError, match="expected a name that ends in .png or .exr"):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(icoray.FileError, match="nowhere") as error:
        image.save(tmp_path / "nowhere" / "a.png")
    assert isinstance(error.value, OSError) and error.value.kind == "io"


def test_labels_are_in_the_png_and_not_in_the_pixels(renderer, scene, grid, layers, wave):
    field = icoray.Field(wave, long_name="mixing ratio", units="kg kg-1")
    plain = renderer.render(scene, grid, layers, field)
    labelled = renderer.render(scene.replace(labels={"title": "a wave"}, size=(320, 240)), grid, layers, field)
    assert labelled._repr_png_() != plain._repr_png_()
    assert plain.notes["long name"] == "mixing ratio" and plain.notes["units"] == "kg kg-1"
    assert "camera" in plain.notes and plain.notes["field"] == "q"


def test_a_report_consists_of_plain_data(renderer, scene, grid, layers, wave):
    report = renderer.render(scene, grid, layers, wave).report
    assert json.loads(json.dumps(report)) == report
    assert report["rays"] > 0 and report["render_s"] > 0
    assert [report["value_min"], report["value_max"]] == [wave.min(), wave.max()]
    assert report["error_max"] <= 1e-3 and report["bytes_copied"] == 0
    assert "surfaces" in report["left_out"] and report["scheme"] == "alone"


def test_pictures_are_equal_on_any_number_of_threads(scene, grid, layers, wave):
    one, three = (icoray.Renderer(threads).render(scene, grid, layers, wave) for threads in (1, 3))
    np.testing.assert_array_equal(one.pixels, three.pixels)


def test_scenes_of_several_fields_take_a_dict(renderer, scene, grid, layers, wave):
    surface = {"layer": 0, "field": "t", "transfer": {"map": "vik", "range": [-1, 1]}}
    both = scene.replace(surfaces=[surface])
    assert both.fields == ["q", "t"]
    temperature = icoray.Field(np.sin(wave).astype(np.float32), long_name="temperature")
    image = renderer.render(both, grid, layers, {"q": wave, "t": temperature, "unused": wave})
    assert (image.pixels != renderer.render(scene, grid, layers, wave).pixels).any()
    assert "temperature" in image.notes["other fields"]
    with pytest.raises(icoray.SceneError, match='shows field "t"'):
        renderer.render(both, grid, layers, {"q": wave})
    with pytest.raises(icoray.ArgumentError, match="no fields"):
        renderer.render(both, grid, layers, {})


def test_native_heights_are_an_array(renderer, scene, grid, layers, wave):
    native = scene.replace(heights="native")
    flat = np.broadcast_to(np.asarray(layers.radius_m) - 6.371e6, wave.shape)
    hill = flat + 3e3 * wave
    one, other = (renderer.render(native, grid, layers, wave, heights=h) for h in (flat, hill))
    assert (one.pixels != other.pixels).any() and other.report["bytes_copied"] == 0
    with pytest.raises(icoray.SceneError, match="no heights of columns are given"):
        renderer.render(native, grid, layers, wave)
    with pytest.raises(icoray.LayersError):
        renderer.render(native, grid, layers, wave, heights=-hill)


def test_a_scene_for_a_gpu_reports_why_the_cpu_drew_it(renderer, scene, grid, layers, wave):
    image = renderer.render(scene.replace(backend="gpu"), grid, layers, wave)
    report = image.report
    assert (report["device"] is None) == (report["left_to_cpu"] is not None)
    if report["device"] is None:
        np.testing.assert_array_equal(image.pixels, renderer.render(scene, grid, layers, wave).pixels)


def test_layers_are_checked():
    layers = icoray.Layers([6.4e6, 6.5e6], 6.371e6)
    assert len(layers) == 2 and layers.planet_radius_m == 6.371e6 and layers.radius_m.tolist() == [6.4e6, 6.5e6]
    with pytest.raises(icoray.LayersError, match="layers 1 and 2 of 3: radii 1 and 1") as error:
        icoray.Layers([1.0, 1.0, 2.0], 1.0)
    assert error.value.kind == "layers" and isinstance(error.value, icoray.Error) and isinstance(error.value, ValueError)
