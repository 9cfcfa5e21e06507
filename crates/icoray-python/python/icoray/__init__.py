"""Ray casting of geodesic grids (MPAS, ICON) over numpy arrays.

A `Renderer` draws a `Scene` of a `Grid`, `Layers` and a `Field`; the `Image` has pixels, errors and a report. A
`Context` draws inside of a running model, as the C interface does, alone or over the ranks of an MPI communicator.

>>> import icoray, numpy
>>> grid = icoray.Grid.icosahedral(3)
>>> layers = icoray.Layers.from_heights([0.0, 50e3, 100e3], 6.371e6)
>>> values = numpy.linspace(0.0, 1.0, 3 * grid.cells).reshape(grid.cells, 3)
>>> scene = icoray.Scene(
...     field="q",
...     size=(64, 64),
...     camera={"lon": 10, "lat": 40, "distance": 4},
...     transfer={"map": "viridis", "range": [0, 1], "opacity": [[0, 0.0], [1, 0.9]]},
... )
>>> image = icoray.Renderer().render(scene, grid, layers, icoray.Field(values))
>>> image.pixels.shape, image.report["bytes_copied"]
((64, 64, 4), 0)
"""

from ._errors import (
    ArgumentError,
    BusyError,
    DisabledError,
    Error,
    ExistsError,
    FieldError,
    FileError,
    ForkedError,
    GridError,
    InternalError,
    LayersError,
    MpiError,
    OrderError,
    OutOfMemoryError,
    SceneError,
    UnsupportedError,
)
from ._icoray import Context, Field, Grid, Image, Layers, Renderer, Scene, __version__
from ._render import Dataset, View, open, render, sample, view

__all__ = [
    "ArgumentError",
    "BusyError",
    "Context",
    "Dataset",
    "DisabledError",
    "Error",
    "ExistsError",
    "Field",
    "FieldError",
    "FileError",
    "ForkedError",
    "Grid",
    "GridError",
    "Image",
    "InternalError",
    "Layers",
    "LayersError",
    "MpiError",
    "OrderError",
    "OutOfMemoryError",
    "Renderer",
    "Scene",
    "SceneError",
    "UnsupportedError",
    "View",
    "__version__",
    "open",
    "render",
    "sample",
    "view",
]
