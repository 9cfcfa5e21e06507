"""Which arrays are borrowed, and which are copied and say so."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import LAYERS

import icoray

NPROMA = 32


def blocks(wave):
    """ICON's (nproma, layers, blocks), the last block partly filled."""
    count = -(-len(wave) // NPROMA)
    padded = np.full((count * NPROMA, LAYERS), np.nan)
    padded[: len(wave)] = wave
    return padded.reshape(count, NPROMA, LAYERS).transpose(1, 2, 0)


LAYOUTS = {
    "cells first": lambda wave: wave.copy(),
    "layers first": lambda wave: np.ascontiguousarray(wave.T),
    "Fortran's order": lambda wave: np.asfortranarray(wave),
    "transposed view": lambda wave: wave.copy().T,
    "backwards": lambda wave: wave[::-1, ::-1].copy()[::-1, ::-1],
    "every second": lambda wave: np.repeat(np.repeat(wave, 2, 0), 3, 1)[::2, ::3],
    "a part of a larger array": lambda wave: np.pad(wave, ((2, 7), (1, 2)))[2:-7, 1:-2],
    "one more column": lambda wave: np.pad(wave, ((0, 1), (0, 0))),
    "a dimension of one": lambda wave: wave.copy()[None],
    "blocks in Fortran's order": lambda wave: np.asfortranarray(blocks(wave)),
    "blocks in C's order": lambda wave: np.ascontiguousarray(blocks(wave).T),
    "memory without write access": lambda wave: np.frombuffer(wave.tobytes(), wave.dtype).reshape(wave.shape),
    "mask without masked entries": lambda wave: np.ma.masked_array(wave.copy()),
}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_floats_of_any_strides_are_borrowed(layout, dtype, renderer, scene, grid, layers, wave):
    wave = wave.astype(dtype)
    expected = renderer.render(scene, grid, layers, wave).pixels
    array = LAYOUTS[layout](wave).astype(dtype, copy=False)
    field = icoray.Field(array)
    assert field.bytes_copied == 0 and np.shares_memory(field.values, array)
    image = renderer.render(scene, grid, layers, field)
    np.testing.assert_array_equal(image.pixels, expected)
    assert image.report["bytes_copied"] == 0
    if array.flags.writeable:
        # What is borrowed changes the next picture.
        array *= 0.5
        np.testing.assert_array_equal(
            renderer.render(scene, grid, layers, field).pixels, renderer.render(scene, grid, layers, wave * dtype(0.5)).pixels
        )


COPIES = {
    "big-endian": lambda wave: wave.astype(">f8"),
    "half precision": lambda wave: wave.astype(np.float16),
    "integers": lambda wave: np.round(wave * 100).astype(np.int16),
    "wide integers": lambda wave: np.round(wave * 100).astype(np.uint64),
    "booleans": lambda wave: wave > 0.5,
    "extended precision": lambda wave: wave.astype(np.longdouble),
    "misaligned": lambda wave: np.frombuffer(b"x" + wave.tobytes(), np.uint8)[1:].view("f8").reshape(wave.shape),
    "of a record": lambda wave: _record(wave)["q"],
    "a list": lambda wave: wave.tolist(),
}


def _record(wave):
    record = np.zeros(wave.shape, [("a", "i4"), ("q", "f8")])
    record["q"] = wave
    return record


@pytest.mark.parametrize("kind", COPIES)
def test_arrays_that_cannot_be_borrowed_are_copied_and_reported(kind, renderer, scene, grid, layers, wave):
    scene = scene.replace(transfer={"range": [0, 100]}) if "integers" in kind else scene
    given = COPIES[kind](wave)
    field = icoray.Field(given)
    plain = np.asarray(given, dtype=field.values.dtype)
    assert field.bytes_copied == plain.nbytes > 0
    image = renderer.render(scene, grid, layers, field)
    assert image.report["bytes_copied"] == plain.nbytes
    np.testing.assert_array_equal(image.pixels, renderer.render(scene, grid, layers, plain).pixels)


def test_masked_entries_are_missing(renderer, scene, grid, layers, wave):
    mask = np.zeros(wave.shape, bool)
    mask[: len(mask) // 2] = True
    nan = np.where(mask, np.nan, wave)
    expected = renderer.render(scene, grid, layers, nan)
    assert expected.report["missing_values"] == mask.sum()
    for masked in (np.ma.masked_array(wave, mask), np.ma.masked_array(wave.T, mask.T)):
        field = icoray.Field(masked)
        image = renderer.render(scene, grid, layers, field)
        assert field.bytes_copied == wave.nbytes == image.report["bytes_copied"]
        np.testing.assert_array_equal(image.pixels, expected.pixels)
    assert np.isfinite(wave).all(), "the array itself is not written to"
    for fill, array in ((-9e33, wave), (-9.9e33, wave.astype(np.float32))):
        marked = np.where(mask, array.dtype.type(fill), array)
        image = renderer.render(scene, grid, layers, icoray.Field(marked, fill=fill))
        assert image.report["missing_values"] == mask.sum() and image.report["bytes_copied"] == 0


def test_a_masked_array_of_integers_is_copied_once(renderer, scene, grid, layers, wave):
    packed = np.ma.masked_greater(np.round(wave * 100).astype(np.int32), 50)
    field = icoray.Field(packed)
    assert field.bytes_copied == field.values.nbytes and np.isnan(field.values).sum() == packed.mask.sum()


def test_a_constant_field_is_known_again(renderer, scene, grid, layers, wave):
    """That the values may not change is a promise: a broken one shows that the range was kept."""
    for constant, expected in ((True, 1.0), (False, 2.0)):
        array = wave / wave.max()
        field = icoray.Field(array, constant=constant)
        renderer.render(scene, grid, layers, field)
        array *= 2
        assert renderer.render(scene, grid, layers, field).report["value_max"] == expected


def test_corners_are_averaged_to_cells(renderer, scene, grid, layers):
    values = np.cos(grid.lat_corner_rad)[:, None] * np.ones(LAYERS)
    image = renderer.render(scene, grid, layers, icoray.Field(values, "corner"))
    assert image.report["bytes_derived"] > 0 and image.report["bytes_copied"] == 0
    with pytest.raises(icoray.FieldError, match="corners"):
        renderer.render(scene, grid, layers, values)
    with pytest.raises(icoray.ArgumentError, match='"edge", expected "cell" or "corner"'):
        icoray.Field(values, "edge")


def test_one_dimension_has_a_value_per_column(renderer, scene, grid, layers, wave):
    column = wave[:, 0]
    image = renderer.render(scene, grid, layers, column)
    expected = renderer.render(scene, grid, layers, np.repeat(column[:, None], LAYERS, 1))
    np.testing.assert_array_equal(image.pixels, expected.pixels)
    assert image.report["bytes_copied"] == 0


def test_the_axis_of_the_layers_can_be_given(renderer, scene, layers):
    """A grid of as many cells as layers: 12."""
    grid = icoray.Grid.icosahedral(0)
    layers = icoray.Layers.from_heights(np.linspace(0, 1e4, 12), 6.371e6)
    values = np.linspace(0, 1, 144).reshape(12, 12)
    one, other = (
        renderer.render(scene, grid, layers, icoray.Field(v, layer_axis=axis)).pixels
        for v, axis in ((values, 0), (values.T, -1))
    )
    np.testing.assert_array_equal(one, other)
    other = renderer.render(scene, grid, layers, icoray.Field(values, layer_axis=1)).pixels
    assert (one != other).any()
    with pytest.raises(icoray.ArgumentError, match="layer_axis: 2"):
        icoray.Field(values, layer_axis=2)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_blocks_with_an_axis_of_layers(axis, renderer, scene, grid, layers, wave):
    expected = renderer.render(scene, grid, layers, wave).pixels
    array = np.moveaxis(np.asfortranarray(blocks(wave)), 1, axis)
    image = renderer.render(scene, grid, layers, icoray.Field(array, layer_axis=axis))
    np.testing.assert_array_equal(image.pixels, expected)


def test_wrong_arrays_are_refused(renderer, scene, grid, layers, wave):
    for values, why in ((wave + 1j, "complex128"), (np.array(["a"]), "expected real numbers"), (1.0, "0 dimensions")):
        with pytest.raises(icoray.FieldError, match=why):
            icoray.Field(values)
    for values, why in (
        (wave[:, :3], r"\[642, 3\], expected one dimension of 6 layers or 5"),
        (wave[:-1], r"\[641, 6\]"),
        (wave[:600], "expected"),
    ):
        with pytest.raises(icoray.FieldError, match=why) as error:
            renderer.render(scene, grid, layers, {"q": values})
        assert 'field "q"' in str(error.value) and error.value.kind == "field"


def test_wrappers_of_arrays(renderer, scene, grid, layers, wave):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(wave, dims=("cell", "layer"))
    field = icoray.Field(array)
    assert field.bytes_copied == 0 and np.shares_memory(field.values, wave)
    dask = pytest.importorskip("dask.array")
    lazy = dask.from_array(wave, chunks=100)
    for values in (lazy, xarray.DataArray(lazy, dims=("cell", "layer"))):
        field = icoray.Field(values)
        assert field.bytes_copied == wave.nbytes
        np.testing.assert_array_equal(field.values, wave)


def test_arrays_of_gpus_are_fetched(wave):
    class OfGpu:
        """As cupy's."""

        __cuda_array_interface__ = {"shape": wave.shape}

        def get(self):
            return wave.copy()

    assert icoray.Field(OfGpu()).bytes_copied == wave.nbytes


def test_buffers_are_borrowed(wave):
    memory = bytearray(wave.tobytes())
    assert icoray.Field(memoryview(memory).cast("d")).bytes_copied == 0
