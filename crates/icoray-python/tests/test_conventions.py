"""Small files of each convention, read as the packages of the field read them."""

from __future__ import annotations

import pathlib
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import icoray

xarray = pytest.importorskip("xarray", reason="xarray is not installed")
import datasets  # noqa: E402

# Degrees of longitude and latitude of cells, triangles of them where the field is there, and values.
Read = tuple[Any, Any, Any, Any]

RADIUS_M = 6_371_229.0

@pytest.fixture(autouse=True)
def without_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


# Attributes of coordinates.
LON = {"standard_name": "longitude", "units": "degrees_east"}
LAT = {"standard_name": "latitude", "units": "degrees_north"}


def values(lon_deg: Any, lat_deg: Any) -> Any:
    """float32 at places: waves without a symmetry, so that a mirrored or shifted mesh has another picture."""
    lon, lat = np.radians(lon_deg), np.radians(lat_deg)
    wave = 9 * np.cos(lat) * np.cos(lon - 0.4) + 5 * np.sin(lat - 0.2) + np.cos(lat) * np.sin(5 * lon)
    return (300 + wave).astype(np.float32)


def places(mesh: icoray.Grid) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """Degrees of the cells and of the corners, which are triangles of cells."""
    cells, corners = (mesh.lon_center_rad, mesh.lat_center_rad), (mesh.lon_corner_rad, mesh.lat_corner_rad)
    return (np.degrees(cells[0]), np.degrees(cells[1])), (np.degrees(corners[0]), np.degrees(corners[1]))


def mpas(mesh: icoray.Grid) -> Any:
    tables = datasets.mpas(mesh).drop_vars(["theta", "vorticity", "surface_pressure", "xtime", "zgrid"])
    return tables.assign(h=("nCells", values(*places(mesh)[0])))


def icon(mesh: icoray.Grid) -> Any:
    """ICON's grid file, whose tables have the triangles last and numbers from 1, with a field at triangles."""
    (vlon, vlat), (clon, clat) = places(mesh)
    vertices, edges, of_edge = (np.asarray(table) for table in (mesh.corner_cell, mesh.corner_edge, mesh.edge_corner))
    ends = np.array([sorted(set(vertices[a]) & set(vertices[b])) for a, b in of_edge])
    neighbors = of_edge[edges].sum(axis=2) - np.arange(len(edges))[:, None]
    # uxarray asks for places of edges too.
    elon, elat = vlon[ends[:, 0]], vlat[ends[:, 0]]
    tables = {"vlon": ("vertex", vlon), "vlat": ("vertex", vlat), "clon": ("cell", clon), "clat": ("cell", clat)}
    tables |= {"elon": ("edge", elon), "elat": ("edge", elat)}
    dataset = xarray.Dataset({name: (dim, np.radians(v), {"units": "radian"}) for name, (dim, v) in tables.items()})
    for name, dims, table in (
        ("vertex_of_cell", ("nv", "cell"), vertices),
        ("edge_of_cell", ("nv", "cell"), edges),
        ("neighbor_cell_index", ("nv", "cell"), neighbors),
        ("adjacent_cell_of_edge", ("nc", "edge"), of_edge),
        ("edge_vertices", ("nc", "edge"), ends),
    ):
        dataset[name] = (dims, table.T.astype(np.int32) + 1)
    return dataset.assign(h=("cell", values(clon, clat), {"coordinates": "clon clat"}))


def ugrid(mesh: icoray.Grid, base: int, is_transposed: bool) -> Any:
    """UGRID of triangles, with a field at faces."""
    (lon, lat), (face_lon, face_lat) = places(mesh)
    topology = {
        "cf_role": "mesh_topology",
        "topology_dimension": 2,
        "node_coordinates": "x y",
        "face_node_connectivity": "tri",
        "face_dimension": "face",
    }
    table = np.asarray(mesh.corner_cell, np.int32) + base
    numbered = {"start_index": np.int32(base)}
    rows = (("three", "face"), table.T, numbered) if is_transposed else (("face", "three"), table, numbered)
    dataset = xarray.Dataset({"mesh": ((), np.int32(0), topology), "tri": rows})
    dataset["x"], dataset["y"] = ("node", lon, LON), ("node", lat, LAT)
    return dataset.assign(h=("face", values(face_lon, face_lat), {"mesh": "mesh", "location": "face"}))


def fesom(mesh: icoray.Grid) -> Any:
    """fesom.mesh.diag.nc without UGRID's variables, in radians, tables transposed, with a field at nodes."""
    (lon, lat), _ = places(mesh)
    dataset = xarray.Dataset({"nodes": (("n2", "nod2"), np.radians([lon, lat]))})
    dataset["elements"] = (("n3", "elem"), np.asarray(mesh.corner_cell, np.int32).T + 1)
    return dataset.assign(h=("nod2", values(lon, lat)))


def fvcom(mesh: icoray.Grid) -> Any:
    (lon, lat), (lonc, latc) = places(mesh)
    dataset = xarray.Dataset({"lon": ("node", lon), "lat": ("node", lat)})
    dataset["lonc"], dataset["latc"] = ("nele", lonc), ("nele", latc)
    dataset["nv"] = (("three", "nele"), np.asarray(mesh.corner_cell, np.int32).T + 1)
    return dataset.assign(h=("nele", values(lonc, latc)))


def scrip(mesh: icoray.Grid) -> Any:
    """SCRIP's cells with their corners, of which pentagons repeat one."""
    (lon, lat), corners = places(mesh)
    table = np.asarray(mesh.cell_corner)
    units = {"units": "degrees"}
    dataset = xarray.Dataset({"grid_dims": ("grid_rank", [mesh.cells])})
    for name, center, corner in (("lon", lon, corners[0]), ("lat", lat, corners[1])):
        dataset[f"grid_center_{name}"] = ("grid_size", center, units)
        dataset[f"grid_corner_{name}"] = (("grid_size", "grid_corners"), corner[table], units)
    dataset["grid_area"] = ("grid_size", np.full(mesh.cells, 4 * np.pi / mesh.cells))
    dataset["grid_imask"] = ("grid_size", np.ones(mesh.cells, np.int32))
    return dataset.assign(h=("grid_size", values(lon, lat)))


def esmf(mesh: icoray.Grid) -> Any:
    """ESMF's elements, of which pentagons have a mark after their nodes."""
    (lon, lat), corners = places(mesh)
    table = np.array(mesh.cell_corner, np.int32) + 1
    count = np.array([len(set(row)) for row in table], np.int8)
    rows = [[*dict.fromkeys(row), *[-1] * 6][:6] for row in table.tolist()]
    dataset = xarray.Dataset({"nodeCoords": (("nodeCount", "coordDim"), np.transpose(corners), {"units": "degrees"})})
    mark = {"_FillValue": np.int32(-1)}
    dataset["elementConn"] = (("elementCount", "maxNodePElement"), np.array(rows, np.int32), mark)
    dataset["numElementConn"] = ("elementCount", count)
    dataset["centerCoords"] = (("elementCount", "coordDim"), np.transpose([lon, lat]), {"units": "degrees"})
    return dataset.assign(h=("elementCount", values(lon, lat)))


def healpix(_mesh: icoray.Grid) -> Any:
    healpy = pytest.importorskip("healpy", reason="healpy is not installed")
    crs = {"grid_mapping_name": "healpix", "refinement_level": np.int32(3), "indexing_scheme": "nested"}
    lon, lat = healpy.pix2ang(8, np.arange(768), nest=True, lonlat=True)
    dataset = xarray.Dataset({"crs": ((), np.int32(0), crs)})
    return dataset.assign(h=("cell", values(lon, lat), {"grid_mapping": "crs"}))


def columns(mesh: icoray.Grid) -> Any:
    """History of CAM-SE: columns with coordinates alone."""
    (lon, lat), _ = places(mesh)
    dataset = xarray.Dataset({"lat": ("ncol", lat, LAT), "lon": ("ncol", lon, LON)})
    return dataset.assign(h=("ncol", values(lon, lat), {"coordinates": "lat lon"}))


def curvilinear(_mesh: icoray.Grid) -> Any:
    """CF's coordinates of two dimensions, of a region."""
    y, x = np.meshgrid(np.linspace(-30, 50, 33), np.linspace(-40, 60, 41), indexing="ij")
    lon, lat = x + 0.1 * y, y + 0.05 * x
    coordinates = {"nav_lon": (("y", "x"), lon, LON), "nav_lat": (("y", "x"), lat, LAT)}
    return xarray.Dataset({"h": (("y", "x"), values(lon, lat))}, coords=coordinates)


def mpas_by_xarray(path: pathlib.Path) -> Read:
    data = xarray.open_dataset(path)
    return np.degrees(data.lonCell), np.degrees(data.latCell), None, data.h


def icon_by_xarray(path: pathlib.Path) -> Read:
    data = xarray.open_dataset(path)
    return np.degrees(data.vlon), np.degrees(data.vlat), data.vertex_of_cell.values.T - 1, data.h


def fesom_by_xarray(path: pathlib.Path) -> Read:
    data = xarray.open_dataset(path)
    return *np.degrees(data.nodes.values), None, data.h


def fvcom_by_xarray(path: pathlib.Path) -> Read:
    data = xarray.open_dataset(path)
    return data.lon, data.lat, data.nv.values.T - 1, data.h


def scrip_by_xarray(path: pathlib.Path) -> Read:
    data = xarray.open_dataset(path)
    return data.grid_center_lon, data.grid_center_lat, None, data.h


def healpix_by_healpy(path: pathlib.Path) -> Read:
    import healpy

    data = xarray.open_dataset(path)
    lon, lat = healpy.pix2ang(2**data.crs.refinement_level, np.arange(data.h.size), nest=True, lonlat=True)
    return lon, lat, None, data.h


def by_cf_xarray(path: pathlib.Path) -> Read:
    """Coordinates by their attributes."""
    pytest.importorskip("cf_xarray", reason="cf_xarray is not installed")
    data = xarray.open_dataset(path)
    return data.cf["longitude"], data.cf["latitude"], None, data.h


def by_uxarray(path: pathlib.Path) -> Read:
    """A field at triangles or, of MPAS, at polygons."""
    data = pytest.importorskip("uxarray", reason="uxarray is not installed").open_dataset(path, path)
    grid, field = data.uxgrid, data.h
    assert field.dims == ("n_face",)
    if grid.n_max_face_nodes > 3:
        return grid.face_lon, grid.face_lat, None, field
    return grid.node_lon, grid.node_lat, grid.face_node_connectivity.values, field


CASES: dict[str, tuple[Callable[[icoray.Grid], Any], Callable[[pathlib.Path], Read]]] = {
    "MPAS, xarray": (mpas, mpas_by_xarray),
    "MPAS, uxarray": (mpas, by_uxarray),
    "ICON, xarray": (icon, icon_by_xarray),
    "ICON, uxarray": (icon, by_uxarray),
    "UGRID from 0, uxarray": (lambda mesh: ugrid(mesh, 0, False), by_uxarray),
    "UGRID from 1, uxarray": (lambda mesh: ugrid(mesh, 1, False), by_uxarray),
    "UGRID transposed, uxarray": (lambda mesh: ugrid(mesh, 1, True), by_uxarray),
    "FESOM2, xarray": (fesom, fesom_by_xarray),
    "FVCOM, xarray": (fvcom, fvcom_by_xarray),
    "SCRIP, xarray": (scrip, scrip_by_xarray),
    "SCRIP, uxarray": (scrip, by_uxarray),
    "ESMF, uxarray": (esmf, by_uxarray),
    "HEALPix, healpy": (healpix, healpix_by_healpy),
    "columns, cf_xarray": (columns, by_cf_xarray),
    "lat(y, x), cf_xarray": (curvilinear, by_cf_xarray),
}


@pytest.mark.parametrize(("write", "read"), CASES.values(), ids=CASES.keys())
def test_files_are_read_as_others_read_them(
    write: Callable[[icoray.Grid], Any], read: Callable[[pathlib.Path], Read], tmp_path: pathlib.Path
):
    path = tmp_path / "small.nc"
    write(datasets.grid()).to_netcdf(path)
    *lon_lat, triangles, values_read = read(path)
    lon, lat = (np.radians(np.asarray(part).ravel()) for part in lon_lat)
    field = np.asarray(values_read).ravel()
    data = icoray.open(path, radius=RADIUS_M)
    scene = data.scene("h", size=(160, 120), cmap="viridis", range=(285, 316), lon=10, lat=15)
    image = data.render(scene=scene)
    if triangles is None:
        grid, values_at = icoray.Grid.from_points(lon, lat), icoray.Field(field)
    else:
        grid = icoray.Grid.from_triangles(lon, lat, np.ascontiguousarray(triangles, np.int32))
        values_at = icoray.Field(field, location="corner")
    layers = icoray.Layers.from_heights([0.0, RADIUS_M / 1000], RADIUS_M)
    by_hand = icoray.Renderer().render(scene, grid, layers, values_at)
    for end in ("value_min", "value_max"):
        assert image.report[end] == by_hand.report[end], end
    # The last bits of places decide which diagonal four places on a circle have, as many of HEALPix are.
    assert np.abs(image.pixels - by_hand.pixels).max() < (2e-2 if write is healpix else 1e-3)
    assert np.ptp(image.pixels[..., :3]) > 0.5


def test_edges_of_uxarray_are_those_of_the_file(tmp_path: pathlib.Path):
    uxarray = pytest.importorskip("uxarray", reason="uxarray is not installed")
    mesh = datasets.grid()
    vertices, edges, of_edge = (np.asarray(table) for table in (mesh.corner_cell, mesh.corner_edge, mesh.edge_corner))
    ends = np.array([sorted(set(vertices[a]) & set(vertices[b])) for a, b in of_edge], np.int32)
    at_edges = values(*places(mesh)[0])[ends].mean(axis=1)
    dataset = ugrid(mesh, 1, False)
    dataset["ends"] = (("edge", "two"), ends + 1, {"start_index": np.int32(1)})
    dataset.mesh.attrs["edge_node_connectivity"] = "ends"
    dataset = dataset.assign(q=(("time", "edge"), at_edges[None]), mean=("face", at_edges[edges].mean(axis=1)))
    dataset.to_netcdf(tmp_path / "edges.nc")
    look: dict[str, Any] = {"size": (96, 80), "lon": 10, "lat": 15, "cmap": "viridis", "range": (285, 316)}
    expected = icoray.render(dataset, "mean", **look).pixels
    for data in (dataset, uxarray.open_dataset(tmp_path / "edges.nc", tmp_path / "edges.nc")):
        assert np.abs(icoray.render(data, "q", **look).pixels - expected).max() < 1e-3


@pytest.mark.parametrize("version", [2, 3])
def test_zarr_stores_are_opened(version: int, tmp_path: pathlib.Path):
    pytest.importorskip("zarr", reason="zarr is not installed")
    dataset = datasets.mpas(datasets.grid())
    dataset.to_zarr(tmp_path / "store.zarr", zarr_format=version)
    opened = icoray.open(tmp_path / "store.zarr")
    assert opened.times == icoray.open(dataset).times
    look: dict[str, Any] = {"size": (96, 80), "lon": 10, "lat": 20, "time": 1}
    assert (opened.render("theta", **look).pixels == icoray.render(dataset, "theta", **look).pixels).all()
