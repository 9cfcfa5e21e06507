"""Small datasets of xarray, as models write them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray

import icoray

LAYERS = 4
TIMES = 3
RADIUS_M = 6.371e6
HEIGHT_M = np.array([0.0, 2e3, 5e3, 9e3, 14e3])


def grid() -> icoray.Grid:
    return icoray.Grid.icosahedral(3)


def values(lon: Any, lat: Any, layers: int = LAYERS) -> Any:
    """float32 of shape (times, columns, layers): a wave that turns."""
    time, layer = np.arange(TIMES)[:, None, None], np.arange(layers)[None, None, :]
    wave = np.cos(lat)[None, :, None] * np.cos(3 * lon[None, :, None] - time)
    return (300 + 20 * wave + 2 * layer).astype(np.float32)


def mpas(mesh: icoray.Grid) -> xarray.Dataset:
    """MPAS-Atmosphere: tables numbered from 1, levels fastest, dates as text."""
    corners_of_cells = np.asarray(mesh.cell_corner) + 1
    count = np.array([len(set(row)) for row in corners_of_cells], np.int32)
    tables = {
        "lonCell": ("nCells", np.asarray(mesh.lon_center_rad)),
        "latCell": ("nCells", np.asarray(mesh.lat_center_rad)),
        "lonVertex": ("nVertices", np.asarray(mesh.lon_corner_rad)),
        "latVertex": ("nVertices", np.asarray(mesh.lat_corner_rad)),
        "verticesOnCell": (("nCells", "maxEdges"), corners_of_cells),
        "nEdgesOnCell": ("nCells", count),
        "cellsOnVertex": (("nVertices", "vertexDegree"), np.asarray(mesh.corner_cell) + 1),
        "edgesOnVertex": (("nVertices", "vertexDegree"), np.asarray(mesh.corner_edge) + 1),
        "verticesOnEdge": (("nEdges", "TWO"), np.asarray(mesh.edge_corner) + 1),
        "zgrid": (("nCells", "nVertLevelsP1"), np.tile(HEIGHT_M.astype(np.float32), (mesh.cells, 1))),
        "xtime": ("Time", np.array([f"2003-01-0{day}_06:00:00" for day in (1, 2, 3)], "S64")),
    }
    dataset = xarray.Dataset(tables, attrs={"on_a_sphere": "YES", "sphere_radius": RADIUS_M})
    theta = values(mesh.lon_center_rad, mesh.lat_center_rad)
    dataset["theta"] = (("Time", "nCells", "nVertLevels"), theta, {"units": "K", "long_name": "Potential temperature"})
    vorticity = values(mesh.lon_corner_rad, mesh.lat_corner_rad).astype(float)
    dataset["vorticity"] = (("Time", "nVertices", "nVertLevels"), vorticity)
    dataset["surface_pressure"] = (("Time", "nCells"), theta[:, :, 0].copy())
    return dataset


def icon(mesh: icoray.Grid) -> xarray.Dataset:
    """ICON: triangles with their points, columns fastest, decoded dates."""
    of = np.asarray(mesh.corner_cell)
    coordinates = {
        "clon": ("ncells", np.degrees(mesh.lon_corner_rad), {"units": "degrees", "bounds": "clon_bnds"}),
        "clat": ("ncells", np.degrees(mesh.lat_corner_rad), {"units": "degrees", "bounds": "clat_bnds"}),
        "clon_bnds": (("ncells", "vertices"), np.degrees(mesh.lon_center_rad)[of]),
        "clat_bnds": (("ncells", "vertices"), np.degrees(mesh.lat_center_rad)[of]),
        "time": ("time", np.array(["2003-01-01T06", "2003-01-02T06", "2003-01-03T06"], "datetime64[ns]")),
        "height": ("height", HEIGHT_M[:LAYERS], {"units": "m"}),
    }
    dataset = xarray.Dataset(coords=coordinates)
    temperature = values(mesh.lon_corner_rad, mesh.lat_corner_rad).transpose(0, 2, 1)
    dataset["ta"] = (("time", "height", "ncells"), np.ascontiguousarray(temperature), {"units": "K"})
    return dataset
