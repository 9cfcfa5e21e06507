"""Datasets of xarray and uxarray as lists of variables that the compiled module reads.

A store gives the names, types and dimensions of variables, their attributes, and blocks of their values. Values that
are in memory are given in place; others are loaded or computed, and a flag distinguishes them.
"""

from __future__ import annotations

import glob
import importlib
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ._errors import ArgumentError

_MPAS_NAMES = {"n_face": "nCells", "n_node": "nVertices", "n_edge": "nEdges"}
_SECONDS = "seconds since 1970-01-01"


class Store:
    """The variables of one xarray dataset.

    Parameters
    ----------
    dataset : xarray.Dataset
    rename : mapping of str to str
        Names of dimensions that are shown by other names.
    """

    def __init__(self, dataset: Any, rename: Mapping[str, str] | None = None) -> None:
        self._dataset = dataset
        self._rename = dict(rename or {})
        self._variables = {str(name): variable for name, variable in dataset.variables.items()}
        times = [str(name) for name in dataset.sizes if str(name).lower() in ("time", "time_counter")]
        times = times or sorted(filter(self._is_time, map(str, dataset.sizes)), key=lambda name: -dataset.sizes[name])[:1]
        self._order = {name: _order(variable.dims, times) for name, variable in self._variables.items()}

    def _is_time(self, dimension: str) -> bool:
        """Whether the coordinate of a dimension is one of time."""
        found = self._variables.get(dimension)
        if found is None:
            return False
        said = {key: str(found.attrs.get(key, "")) for key in ("axis", "standard_name", "units")}
        is_said = said["axis"] == "T" or said["standard_name"] == "time" or " since " in said["units"]
        return is_said or _is_date(found)

    @property
    def name(self) -> str:
        """The file that the dataset was read from, or "dataset"."""
        source = self._dataset.encoding.get("source")
        return str(source) if isinstance(source, (str, os.PathLike)) else "dataset"

    def variables(self) -> list[tuple[str, str, list[tuple[str, int]]]]:
        """Name, kind and dimensions of each variable: time first, the others in their order."""
        return [(name, _kind(variable), self._dimensions(name)) for name, variable in self._variables.items()]

    def _dimensions(self, name: str) -> list[tuple[str, int]]:
        variable = self._variables[name]
        dims = [(self._renamed(variable.dims[i]), variable.shape[i]) for i in self._order[name]]
        if variable.dtype.kind in "SU" and len(dims) == 1:
            dims.append(("StrLen", variable.dtype.itemsize))
        if not dims and _is_date(variable) and name.lower() == "time":
            # The date of a dataset of one time.
            dims.append(("time", 1))
        return dims

    def _renamed(self, name: object) -> str:
        return self._rename.get(str(name), str(name))

    def dimensions(self) -> list[tuple[str, int]]:
        """Name and length of each dimension."""
        return [(self._renamed(name), length) for name, length in self._dataset.sizes.items()]

    def attribute(self, variable: str | None, name: str) -> str | tuple[list[float], bool] | None:
        """An attribute of a variable or of the dataset: text, or numbers and whether they are real ones."""
        if variable is None:
            return _attribute(self._dataset.attrs.get(name))
        found = self._variables[variable]
        if _is_date(found):
            calendar = _calendar(found)
            return {"units": _SECONDS, "calendar": calendar}.get(name) or _attribute(found.attrs.get(name))
        return _attribute(found.attrs.get(name))

    def read(self, name: str, start: Sequence[int], count: Sequence[int]) -> tuple[np.ndarray, bool]:
        """A block of a variable, with its dimensions in the order of `variables`, and whether it is the memory that the
        dataset has."""
        variable = self._variables[name]
        order = self._order[name]
        if _is_date(variable):
            return self._dates(variable)[tuple(slice(s, s + c) for s, c in zip(start, count))], False
        block = {variable.dims[i]: slice(start[k], start[k] + count[k]) for k, i in enumerate(order)}
        in_memory = bool(getattr(variable, "_in_memory", False))
        data = variable.isel(block).data
        if not isinstance(data, np.ndarray):
            in_memory = False
            data = data.get() if hasattr(data, "get") and hasattr(data, "__cuda_array_interface__") else data
            data = np.asarray(data)
        return data.transpose(order), in_memory

    def texts(self, name: str, rows: int) -> list[str | None]:
        """The first rows of a variable of text."""
        values = np.asarray(self._variables[name].isel({self._variables[name].dims[0]: slice(0, rows)}).values)
        texts: list[str | None] = [_text(value) for value in values.reshape(len(values), -1)[:, 0]]
        return texts + [None] * (rows - len(texts))

    @staticmethod
    def _dates(variable: Any) -> np.ndarray:
        values = np.atleast_1d(variable.values)
        if values.dtype.kind == "M":
            seconds = values.astype("datetime64[ns]").astype(np.int64) / 1e9
            return np.where(np.isnat(values), np.nan, seconds)
        cftime = importlib.import_module("cftime")
        return np.asarray(cftime.date2num(values, _SECONDS, calendar=_calendar(variable)), dtype=np.float64)


def _order(dims: Iterable[object], times: Sequence[str]) -> list[int]:
    """Numbers of the dimensions, those of time first."""
    names = [str(name) for name in dims]
    return sorted(range(len(names)), key=lambda i: names[i] not in times)


def _is_date(variable: Any) -> bool:
    if variable.dtype.kind == "M":
        return True
    if variable.dtype.kind != "O" or variable.size == 0 or variable.ndim > 1:
        return False
    return hasattr(np.atleast_1d(variable.values)[0], "calendar")


def _calendar(variable: Any) -> str:
    if variable.dtype.kind == "M":
        return "proleptic_gregorian"
    return str(np.atleast_1d(variable.values)[0].calendar)


def _kind(variable: Any) -> str:
    kind, size = variable.dtype.kind, variable.dtype.itemsize
    if kind == "f":
        return "f32" if size <= 4 else "f64"
    if kind in "iub":
        return "integer"
    if kind in "SU":
        return "text"
    return "f64" if _is_date(variable) else "other"


def _attribute(value: object) -> str | tuple[list[float], bool] | None:
    if value is None:
        return None
    if isinstance(value, (str, bytes)):
        return _text(value)
    array = np.asarray(value)
    if array.dtype.kind in "fiub":
        return [float(number) for number in array.ravel()], array.dtype.kind == "f"
    if array.dtype.kind in "SU" and array.size:
        return _text(array.ravel()[0])
    return None


def _text(value: object) -> str:
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.strip("\0 \t\r\n")


def stores(data: Any, mesh: Any = ()) -> tuple[list[Store], list[Store]]:
    """The stores of what a user gives: those with the fields, and those with what these lack.

    Parameters
    ----------
    data : xarray.Dataset, xarray.DataArray, uxarray.UxDataset, uxarray.UxDataArray, str or os.PathLike, or a sequence
    mesh : the same, uxarray.Grid, or a sequence of these
    """
    found = [_stores(one) for one in _each(data)]
    others = [grid for one in found for grid in one[1:]] + [store for one in _each(mesh) for store in _stores(one)]
    return [one[0] for one in found], others


def _each(data: Any) -> list[Any]:
    """The datasets of what a user gives: one, several, or the files that fit a pattern, in the order of their names."""
    if isinstance(data, (str, os.PathLike)):
        path = os.fspath(data)
        # Addresses have question marks.
        if os.path.exists(path) or "://" in str(path) or not glob.has_magic(path):
            return [data]
        files = sorted(glob.glob(path))
        if not files:
            raise ArgumentError(f"data or mesh: no file fits {path!r}, expected a pattern such as 'history.*.nc'")
        return files
    if hasattr(data, "dims") or hasattr(data, "face_node_connectivity") or not isinstance(data, Iterable):
        return [data]
    return [one for part in data for one in _each(part)]


def _stores(data: Any) -> list[Store]:
    if isinstance(data, (str, os.PathLike)):
        return [Store(importlib.import_module("xarray").open_dataset(data))]
    if hasattr(data, "face_node_connectivity") and hasattr(data, "n_face"):
        return [_grid(data)]
    grid = getattr(data, "uxgrid", None)
    if hasattr(data, "to_dataset") and hasattr(data, "dtype"):
        data = data.to_dataset(name=data.name if data.name is not None else "values")
    if not hasattr(data, "variables") or not hasattr(data, "sizes"):
        message = f"data or mesh: a {type(data).__name__}, expected a dataset of xarray or uxarray, or the path of a file"
        raise ArgumentError(message)
    if grid is None:
        return [Store(data)]
    return [Store(data, _names(grid)), _grid(grid)]


def _names(grid: Any) -> dict[str, str]:
    """Names of dimensions of a grid of uxarray: MPAS's own, where its cells are MPAS's."""
    is_mpas = str(getattr(grid, "source_grid_spec", "")).upper() == "MPAS"
    return _MPAS_NAMES if is_mpas and grid.face_node_connectivity.shape[1] > 3 else {}


def _grid(grid: Any) -> Store:
    """Mesh tables of a grid of uxarray: int64, marked by the least of all, and degrees."""
    xarray = importlib.import_module("xarray")
    names = ["node_lon", "node_lat", "face_lon", "face_lat", "face_node_connectivity"]
    # Those of a file, whose order is that of its values: uxarray derives edges in an order of its own.
    of_file = getattr(grid, "_ds", ())
    names += [name for name in ("edge_node_connectivity", "edge_face_connectivity") if name in of_file]
    tables = {}
    for name in names:
        table = getattr(grid, name)
        tables[name] = xarray.Variable(table.dims, table.values, dict(table.attrs))
    for name in names[:4]:
        tables[name].attrs["units"] = "degrees"
    # uxarray keeps the attribute of files whose tables count from 1, and makes tables that count from 0.
    for name in names[4:]:
        tables[name].attrs["start_index"] = 0
    radius = getattr(grid, "attrs", {}).get("sphere_radius") if isinstance(getattr(grid, "attrs", {}), Mapping) else None
    if radius is None and hasattr(grid, "_ds"):
        radius = grid._ds.attrs.get("sphere_radius")
    attributes = {} if radius is None else {"sphere_radius": radius}
    dataset = xarray.Dataset(tables, attrs=attributes)
    dataset.encoding["source"] = str(getattr(grid, "_source", None) or "uxgrid")
    return Store(dataset, _names(grid))
