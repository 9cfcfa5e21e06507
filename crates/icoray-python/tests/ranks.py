"""A model over the ranks of MPI, run by test_ranks.py: `ranks.py MODE DIRECTORY`."""

from __future__ import annotations

import sys

import numpy as np
from conftest import SCENE, blob
from mpi4py import MPI

import icoray

# Errors of one rank end all of them.
sys.excepthook = lambda *error: (sys.__excepthook__(*error), MPI.COMM_WORLD.Abort(1))  # type: ignore[func-returns-value]

COMM = MPI.COMM_WORLD
STEPS = 3
GRID = icoray.Grid.icosahedral(3)
LAYERS = icoray.Layers.from_heights(np.linspace(1e3, 15e3, 6), 6.371e6)
SCENE_TEXT = SCENE + '[output]\nfile = "{field}_{step}.exr"\nerror = "error_{step}.png"\n'


def wave(step: int) -> np.ndarray:
    return blob(GRID.lon_center_rad + 0.4 * step, GRID.lat_center_rad)


def corner_wave(step: int) -> np.ndarray:
    return blob(GRID.lon_corner_rad + 0.4 * step, GRID.lat_corner_rad)


def own_cells() -> np.ndarray:
    """Bands of latitude, one for each rank."""
    band = np.argsort(np.argsort(GRID.lat_center_rad)) * COMM.size // GRID.cells
    return np.flatnonzero(band == COMM.rank)


def part() -> tuple[icoray.Grid, np.ndarray, int]:
    """This rank's cells and those that share a corner with them, as a grid of their own; their global numbers; how many
    are own."""
    own = own_cells()
    is_own = np.isin(np.arange(GRID.cells), own)
    corners = np.flatnonzero(is_own[GRID.corner_cell].any(1))
    halo = np.setdiff1d(GRID.corner_cell[corners], own)
    cells, edges = np.concatenate([own, halo]), np.unique(GRID.corner_edge[corners])

    def local(chosen: np.ndarray, count: int) -> np.ndarray:
        table = np.full(count, -1)
        table[chosen] = np.arange(len(chosen))
        return table

    cell, corner, edge = (
        local(chosen, count) for chosen, count in ((cells, GRID.cells), (corners, GRID.corners), (edges, GRID.edges))
    )
    # Corners that are not here are missing at the cells of the halo and behind the last edges.
    grid = icoray.Grid(
        lon_center_rad=GRID.lon_center_rad[cells],
        lat_center_rad=GRID.lat_center_rad[cells],
        lon_corner_rad=GRID.lon_corner_rad[corners],
        lat_corner_rad=GRID.lat_corner_rad[corners],
        cell_corner=corner[GRID.cell_corner[cells]],
        corner_cell=cell[GRID.corner_cell[corners]],
        corner_edge=edge[GRID.corner_edge[corners]],
        edge_corner=corner[GRID.edge_corner[edges]],
    )
    return grid, cells, len(own)


def main(mode: str, directory: str) -> None:
    comm: object = COMM.py2f() if mode == "fortran" else COMM
    is_async = mode == "async"
    scene = 'ranks = "fragments"\n' + SCENE_TEXT.replace(".exr", ".png") if mode == "fragments" else SCENE_TEXT
    with icoray.Context(directory, scene, comm, threads=1, async_render=is_async) as context:
        context.layers_set(LAYERS)
        if mode in ("parts", "fragments"):
            grid, cells, owned = part()
            context.grid_set(grid)
            context.part_set(cells, owned)
        else:
            cells = np.arange(GRID.cells)
            context.grid_set(GRID)
        if mode == "columns":
            cells = own_cells()
            context.part_set(cells)
        corners = np.arange(GRID.corners)[COMM.rank :: COMM.size]
        if mode == "corners":
            # Every third triangle, as in no relation to the cells.
            context.part_set(own_cells(), corner_global=corners)
        if mode == "failure":
            failure(context)
        for step in range(STEPS):
            if mode == "corners":
                context.field_set("q", np.ascontiguousarray(corner_wave(step)[corners]), "corner")
            else:
                context.field_set("q", np.ascontiguousarray(wave(step)[cells]))
            assert context.wants(step)
            context.execute(step, 60.0 * step)
        context.wait()
        report = context.report()
        assert report["ranks"] == COMM.size, report
        assert (report["frames_written"] == STEPS) == (COMM.rank == 0)
    # The model's own messages are not disturbed.
    assert COMM.allreduce(1) == COMM.size
    print(f"rank {COMM.rank}: {report['scheme']}")


def failure(context: icoray.Context) -> None:
    """A failure of the last rank is that of all."""
    last = COMM.size - 1
    if COMM.rank != last:
        context.field_set("q", wave(0))
    try:
        context.execute(100)
    except icoray.FieldError as error:
        assert "not given" in str(error) and (COMM.size == 1 or f"rank {last}" in str(error)), error
    else:
        raise AssertionError("no failure")
    try:
        context.part_set([0.5] if COMM.rank == last else np.arange(GRID.cells), 0)
    except icoray.Error:
        pass
    else:
        raise AssertionError("no failure")


if __name__ == "__main__":
    main(*sys.argv[1:])
