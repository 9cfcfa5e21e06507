"""Stand-ins of ICON's ComIn and of Ascent, which run a recipe of the book over the ranks of MPI.

`recipes.py NAME SCRIPT DIRECTORY` runs the script in the directory, for three steps of a model on an icosahedral grid
whose ranks own bands of latitude and have a halo. The stand-ins have what the recipes use, with the names, shapes,
types and orders of the adapters' documentation.
"""

from __future__ import annotations

import os
import pathlib
import sys
import types
from collections.abc import Callable
from typing import Any

import numpy as np
from conftest import SCENE

import icoray

STEPS = 3
#: As many as the recipe for Ascent says.
LAYERS = 26
RADIUS = 6.371229e6
ICOSAHEDRAL = icoray.Grid.icosahedral(3)
#: Points and triangles of the whole grid, which a model reads from a file.
LON, LAT = ICOSAHEDRAL.lon_center_rad, ICOSAHEDRAL.lat_center_rad
TRIANGLES = ICOSAHEDRAL.corner_cell


def owned(lat: np.ndarray, comm: Any) -> np.ndarray:
    """Which places this rank has: a band of latitude, with as many places on each rank."""
    order = np.argsort(np.argsort(lat, kind="stable"), kind="stable")
    return order * comm.size // len(lat) == comm.rank


def wave(lon: np.ndarray, lat: np.ndarray, step: int) -> np.ndarray:
    """Values of shape (places, layers), 0 to 1."""
    near = np.exp(4 * (np.cos(lat) * np.cos(lon - 0.3 - 0.4 * step) - 1))
    return near[:, None] * np.exp(-0.1 * np.arange(LAYERS))


def scene(field: str) -> str:
    """A scene without labels, whose pictures are named by the step."""
    return SCENE.replace('"q"', f'"{field}"') + '[output]\nfile = "{step}.png"\n'


class Handle:
    """A variable, as `comin.var_get` gives it: numpy reads the model's memory through it, as it is at the time."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    @property
    def __array_interface__(self) -> dict[str, Any]:
        return self.array.__array_interface__


def blocked(values: np.ndarray, nproma: int, fill: float) -> np.ndarray:
    """Rows of values as Fortran's (nproma, ..., blocks); the last block is filled up."""
    blocks = -(-len(values) // nproma)
    padded = np.full((nproma * blocks, *values.shape[1:]), fill, values.dtype)
    padded[: len(values)] = values
    return np.asfortranarray(np.moveaxis(padded.reshape(blocks, nproma, *values.shape[1:]), 0, -1))


def comin(script: pathlib.Path, comm: Any) -> None:
    """ICON on this rank: the script is executed once, its callbacks at their entry points."""
    import xarray

    nproma = 48
    lon, lat = ICOSAHEDRAL.lon_corner_rad, ICOSAHEDRAL.lat_corner_rad
    own = owned(lat, comm)
    # Triangles that share a point with own ones are the halo, which stands behind them.
    halo = np.isin(TRIANGLES, TRIANGLES[own]).any(1) & ~own
    cells = np.concatenate([np.flatnonzero(own), np.flatnonzero(halo)])
    if comm.rank == 0:
        tables = {
            "vlon": ("vertex", LON),
            "vlat": ("vertex", LAT),
            "clon": ("cell", lon),
            "clat": ("cell", lat),
            "vertex_of_cell": (("nv", "cell"), TRIANGLES.T + 1),
        }
        xarray.Dataset(tables).to_netcdf("icon_grid.nc")
        pathlib.Path("temp.toml").write_text(scene("temp"))
    comm.Barrier()

    temp = np.full((nproma, LAYERS, -(-len(cells) // nproma), 1, 1), np.nan, order="F")
    decomp = blocked(halo[cells].astype(np.int32), nproma, 0)
    domain = types.SimpleNamespace(
        grid_filename="icon_grid.nc",
        nlev=LAYERS,
        cells=types.SimpleNamespace(
            ncells=len(cells),
            ncells_global=len(lon),
            nblks=temp.shape[2],
            glb_index=memoryview(cells.astype(np.int32) + 1),
            decomp_domain=memoryview(decomp),
        ),
    )
    # Heights of the half levels, the top first.
    globally = types.SimpleNamespace(nproma=nproma, vct_a=memoryview(np.linspace(15e3, 0, LAYERS + 1)))
    callbacks: dict[str, list[Callable[[], None]]] = {}
    date = ""

    def register_callback(entry_point: str) -> Callable[[Callable[[], None]], Callable[[], None]]:
        def register(function: Callable[[], None]) -> Callable[[], None]:
            callbacks.setdefault(entry_point, []).append(function)
            return function

        return register

    def var_get(entry_points: list[str], descriptor: tuple[str, int], flag: int = 0) -> Handle:
        assert entry_points == [module.EP_ATM_WRITE_OUTPUT_BEFORE] and descriptor == ("temp", 1) and flag == 1
        return Handle(temp)

    def run(entry_point: str) -> None:
        for function in callbacks[entry_point]:
            function()

    module: Any = types.ModuleType("comin")
    module.COMIN_FLAG_READ = 1
    module.EP_SECONDARY_CONSTRUCTOR = "constructor"
    module.EP_ATM_WRITE_OUTPUT_BEFORE = "output"
    module.EP_DESTRUCTOR = "destructor"
    module.register_callback = register_callback
    module.var_get = var_get
    module.descrdata_get_domain = {1: domain}.__getitem__
    module.descrdata_get_global = lambda: globally
    module.current_get_datetime = lambda: date
    module.parallel_get_host_mpi_comm = comm.py2f
    sys.modules["comin"] = module

    exec(compile(script.read_text(), script, "exec"), {"__name__": "__main__"})
    run(module.EP_SECONDARY_CONSTRUCTOR)
    for step in range(STEPS):
        date = f"2026-11-24T0{step}:00:00.000"
        values = wave(lon[cells], lat[cells], step)
        # What halos hold must not matter.
        values[halo[cells]] = -1e30
        temp[..., 0, 0] = blocked(values, nproma, np.nan)
        run(module.EP_ATM_WRITE_OUTPUT_BEFORE)
    run(module.EP_DESTRUCTOR)


class Node:
    """A node of Conduit's Python interface, as far as recipes use it."""

    def __init__(self, values: dict[str, Any]) -> None:
        self.values = values

    def child(self, index: int) -> Node:
        return [self][index]

    def __getitem__(self, path: str) -> Any:
        return self.values[path]


def ascent(script: pathlib.Path, comm: Any) -> None:
    """A model that publishes its mesh at each step, in which the script is executed."""
    own = owned(LAT, comm)
    triangles = np.flatnonzero(own[TRIANGLES].any(1))
    cells = np.concatenate([np.flatnonzero(own), np.setdiff1d(TRIANGLES[triangles], np.flatnonzero(own))])
    if comm.rank == 0:
        pathlib.Path("theta.toml").write_text(scene("theta"))
    comm.Barrier()
    local = np.full(len(LON), -1)
    local[cells] = np.arange(len(cells))
    bottom = local[TRIANGLES[triangles]]
    below = [np.hstack([bottom, bottom + len(cells)]) + layer * len(cells) for layer in range(LAYERS - 1)]
    lon, lat = LON[cells], LAT[cells]
    radius = RADIUS + np.linspace(1e3, 15e3, LAYERS)
    directions = {"x": np.cos(lat) * np.cos(lon), "y": np.cos(lat) * np.sin(lon), "z": np.sin(lat)}
    mesh: dict[str, Any] = {
        "coordsets/coords/type": "explicit",
        "topologies/mesh/type": "unstructured",
        "topologies/mesh/coordset": "coords",
        "topologies/mesh/elements/shape": "wedge",
        "topologies/mesh/elements/connectivity": np.concatenate(below).astype(np.int32).ravel(),
        "fields/cell_number/values": np.tile(cells.astype(np.int32), LAYERS),
        "fields/is_own/values": np.tile(own[cells].astype(np.int32), LAYERS),
    }
    for axis, direction in directions.items():
        mesh[f"coordsets/coords/values/{axis}"] = np.outer(radius, direction).ravel()
    names: dict[str, Any] = {"__name__": "__main__", "ascent_mpi_comm_id": comm.py2f}
    for step in range(STEPS):
        theta = wave(lon, lat, step)
        theta[~own[cells]] = -1e30
        mesh |= {"state/cycle": step, "state/time": 3600.0 * step, "fields/theta/values": theta.T.ravel()}
        node = Node(mesh)
        names["ascent_data"] = lambda node=node: node
        exec(compile(script.read_text(), script, "exec"), names)


def main(name: str, script: str, directory: str) -> None:
    # The tests start mpirun, which a process with an MPI of its own cannot.
    from mpi4py import MPI

    comm = MPI.COMM_WORLD
    # Errors of one rank end all of them.
    sys.excepthook = lambda *error: (sys.__excepthook__(*error), comm.Abort(1))  # type: ignore[func-returns-value]
    path = pathlib.Path(script).resolve()
    os.chdir(directory)
    {"comin": comin, "ascent": ascent}[name](path, comm)
    # The model's own messages are not disturbed.
    assert comm.allreduce(1) == comm.size
    print(f"rank {comm.rank}: done")


if __name__ == "__main__":
    main(*sys.argv[1:])
