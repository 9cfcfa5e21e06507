"""Types of the compiled half; its docstrings have shapes and units."""

import datetime
import os
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Final, Literal, Protocol, TypeAlias, TypedDict, final, type_check_only

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

from ._options import Keys

__version__: Final[str]
__all__ = [
    "__version__",
    "Context",
    "Dataset",
    "Field",
    "Grid",
    "Image",
    "Layers",
    "Renderer",
    "Scene",
    "View",
    "sample",
    "write_animation",
]

_Path: TypeAlias = str | os.PathLike[str]
_Location: TypeAlias = Literal["cell", "corner"]
# Arrays of numpy, and of xarray, dask and cupy, which become some.
_Values: TypeAlias = npt.ArrayLike | _Array

@type_check_only
class _Array(Protocol):
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> Any: ...

@type_check_only
class _Colors(TypedDict):
    field: str
    range: list[float]
    how: str

# Figures of a frame.
@type_check_only
class _Report(TypedDict):
    step: int
    time_s: float
    waited_s: float
    copy_s: float
    prepare_s: float
    render_s: float
    write_s: float
    rays: int
    columns: int
    frusta: int
    void_frusta: int
    value_min: float | None
    value_max: float | None
    missing_values: int
    bytes_copied: int
    bytes_derived: int
    error_max: float
    error_mean: float
    error_p999: float
    tolerance: float
    error_is_bound: bool
    pixel_step: int
    lights: str
    threads: int
    ranks: int
    tiles: int
    gather_s: float
    balance: float
    bytes_received: int
    scheme: str
    fragments: int
    fragment_bytes: int
    compose_s: float
    drawn_on: str
    upload_s: float
    device_s: float | None
    bytes_uploaded: int
    edge_pixels: int
    pixels_over_tolerance: int
    rays_per_pixel: float
    sampling_error_max: float | None
    sampling_error_mean: float | None
    cells_per_pixel_max: float
    cells_per_pixel_mean: float
    level: int
    date: str | None
    device: str | None
    left_to_cpu: str | None
    sharing: str | None
    scalar_pieces: int
    samples: int
    color_min: float | None
    color_max: float | None
    colors: list[_Colors]
    left_out: list[str]

@type_check_only
class _ContextReport(TypedDict):
    step: int
    time_s: float
    host_s: float
    waited_s: float
    copy_s: float
    prepare_s: float
    render_s: float
    write_s: float
    rays: int
    columns: int
    frusta: int
    void_frusta: int
    value_min: float | None
    value_max: float | None
    missing_values: int
    bytes_copied: int
    bytes_derived: int
    bytes_peak: int
    error_max: float
    error_mean: float
    error_p999: float
    tolerance: float
    error_is_bound: bool
    pixel_step: int
    lights: str
    threads: int
    frames_written: int
    frames_failed: int
    frames_dropped: int
    host_total_s: float
    write_total_s: float
    ranks: int
    tiles: int
    gather_s: float
    balance: float
    bytes_received: int
    scheme: str
    fragments: int
    fragment_bytes: int
    compose_s: float
    drawn_on: str
    upload_s: float
    device_s: float | None
    bytes_uploaded: int
    frames: int
    edge_pixels: int
    pixels_over_tolerance: int
    rays_per_pixel: float
    sampling_error_max: float | None
    sampling_error_mean: float | None
    cells_per_pixel_max: float
    cells_per_pixel_mean: float
    level: int
# End of figures.

@final
class Grid:
    def __new__(
        cls,
        *,
        lon_center_rad: _Values,
        lat_center_rad: _Values,
        lon_corner_rad: _Values,
        lat_corner_rad: _Values,
        cell_corner: _Values,
        corner_cell: _Values,
        corner_edge: _Values,
        edge_corner: _Values,
        cell_corner_count: _Values | None = None,
        index_base: int = 0,
    ) -> Grid: ...
    @staticmethod
    def from_triangles(
        lon_center_rad: _Values,
        lat_center_rad: _Values,
        corner_cell: _Values,
        *,
        lon_corner_rad: _Values | None = None,
        lat_corner_rad: _Values | None = None,
        index_base: int = 0,
    ) -> Grid: ...
    @staticmethod
    def from_points(lon_center_rad: _Values, lat_center_rad: _Values) -> Grid: ...
    @staticmethod
    def icosahedral(level: int) -> Grid: ...
    @property
    def cells(self) -> int: ...
    @property
    def corners(self) -> int: ...
    @property
    def edges(self) -> int: ...
    @property
    def bytes_copied(self) -> int: ...
    @property
    def index_base(self) -> int: ...
    @property
    def lon_center_rad(self) -> npt.NDArray[np.floating[Any]]: ...
    @property
    def lat_center_rad(self) -> npt.NDArray[np.floating[Any]]: ...
    @property
    def lon_corner_rad(self) -> npt.NDArray[np.floating[Any]]: ...
    @property
    def lat_corner_rad(self) -> npt.NDArray[np.floating[Any]]: ...
    @property
    def cell_corner(self) -> npt.NDArray[np.integer[Any]]: ...
    @property
    def cell_corner_count(self) -> npt.NDArray[np.integer[Any]] | None: ...
    @property
    def corner_cell(self) -> npt.NDArray[np.integer[Any]]: ...
    @property
    def corner_edge(self) -> npt.NDArray[np.integer[Any]]: ...
    @property
    def edge_corner(self) -> npt.NDArray[np.integer[Any]]: ...

@final
class Layers:
    def __new__(cls, radius_m: _Values, planet_radius_m: float) -> Layers: ...
    @staticmethod
    def from_heights(height_m: _Values, planet_radius_m: float) -> Layers: ...
    @property
    def radius_m(self) -> npt.NDArray[np.float64]: ...
    @property
    def planet_radius_m(self) -> float: ...
    def __len__(self) -> int: ...

@final
class Field:
    def __new__(
        cls,
        values: _Values,
        location: _Location = "cell",
        fill: float | None = None,
        *,
        layer_axis: int | None = None,
        long_name: str | None = None,
        units: str | None = None,
        constant: bool = False,
    ) -> Field: ...
    @property
    def bytes_copied(self) -> int: ...
    @property
    def values(self) -> npt.NDArray[np.floating[Any]]: ...
    @property
    def location(self) -> _Location: ...
    @property
    def fill(self) -> float | None: ...
    @property
    def long_name(self) -> str | None: ...
    @property
    def units(self) -> str | None: ...

@final
class Scene:
    def __new__(
        cls,
        source: _Path | None = None,
        /,
        *,
        view: str | None = None,
        size: Sequence[int] | None = None,
        **keys: Unpack[Keys],
    ) -> Scene: ...
    @staticmethod
    def parse(text: str, *, view: str | None = None) -> Scene: ...
    def replace(self, *, size: Sequence[int] | None = None, **keys: Unpack[Keys]) -> Scene: ...
    def to_toml(self) -> str: ...
    @property
    def field(self) -> str: ...
    @property
    def fields(self) -> list[str]: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class Renderer:
    def __new__(cls, threads: int = 0) -> Renderer: ...
    @property
    def threads(self) -> int: ...
    def render(
        self,
        scene: Scene | _Path,
        grid: Grid,
        layers: Layers,
        field: Field | _Values | dict[str, Any],
        *,
        heights: Field | _Values | None = None,
    ) -> Image: ...

@final
class Image:
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def pixels(self) -> npt.NDArray[np.float32]: ...
    @property
    def error(self) -> npt.NDArray[np.float32]: ...
    @property
    def report(self) -> _Report: ...
    @property
    def notes(self) -> dict[str, str]: ...
    def to_rgba8(self) -> npt.NDArray[np.uint8]: ...
    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]: ...
    def show(self) -> None: ...
    def save(self, path: _Path) -> None: ...
    def error_map(self, path: _Path) -> None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Context:
    def __new__(
        cls,
        output_dir: _Path | None = None,
        scene: Scene | _Path | None = None,
        comm: Any = None,
        *,
        threads: int = 0,
        existing: Literal["keep", "overwrite"] = "keep",
        on_error: Literal["warn", "ignore", "disable"] = "warn",
        disable_after: int = 0,
        async_render: bool = False,
        writer_queue: int = 0,
        when_full: Literal["block", "drop"] = "block",
    ) -> Context: ...
    def grid_set(self, grid: Grid, name: str = "") -> None: ...
    def part_set(
        self,
        cell_global: _Values,
        owned_cells: int | None = None,
        is_owned: _Values | None = None,
        *,
        corner_global: _Values | None = None,
        owned_corners: int | None = None,
        is_corner_owned: _Values | None = None,
        grid: str = "",
    ) -> None: ...
    def layers_set(self, layers: Layers, name: str = "") -> None: ...
    def heights_set(
        self,
        values: Field | _Values | None,
        location: _Location = "cell",
        fill: float | None = None,
        *,
        layer_axis: int | None = None,
        grid: str = "",
        layers: str = "",
    ) -> None: ...
    def field_set(
        self,
        name: str,
        values: Field | _Values,
        location: _Location = "cell",
        fill: float | None = None,
        *,
        layer_axis: int | None = None,
        grid: str = "",
        layers: str = "",
    ) -> None: ...
    def field_describe(self, name: str, long_name: str | None = None, units: str | None = None) -> None: ...
    def scene_load(self, path: _Path) -> None: ...
    def scene_text(self, text: str) -> None: ...
    def wants(self, step: int, time_s: float = 0.0, field: str | None = None) -> bool: ...
    def execute(
        self,
        step: int,
        time_s: float = 0.0,
        date: str | datetime.datetime | np.datetime64 | None = None,
    ) -> None: ...
    def wait(self) -> None: ...
    def report(self) -> _ContextReport: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...
    def __enter__(self) -> Context: ...
    def __exit__(
        self,
        *_error: type[BaseException] | BaseException | TracebackType | None,
    ) -> None: ...

def sample() -> dict[str, Any]: ...
def write_animation(path: _Path, pictures: Sequence[_Path], fps: float) -> None: ...
@final
class Dataset:
    def __new__(
        cls,
        fields: Sequence[Any],
        others: Sequence[Any],
        *,
        at: Mapping[str, int] | None = None,
        heights: tuple[float, float] | None = None,
        radius: float | None = None,
        missing: Sequence[float] | None = None,
    ) -> Dataset: ...
    @property
    def likely_fields(self) -> list[str]: ...
    @property
    def fields(self) -> dict[str, dict[str, Any]]: ...
    @property
    def times(self) -> list[str | None]: ...
    @property
    def convention(self) -> str: ...
    @property
    def cells(self) -> int: ...
    @property
    def corners(self) -> int: ...
    @property
    def sphere_radius_m(self) -> float: ...
    def layer_heights(self, field: str) -> list[float]: ...
    def scene(self, renderer: Renderer, request: dict[str, Any]) -> Scene: ...
    def render(
        self, renderer: Renderer, request: dict[str, Any], progress: Callable[[int, int], object] | None = None
    ) -> Image: ...
    def view(
        self,
        renderer_threads: int,
        request: dict[str, Any],
        port: int | None = None,
    ) -> View: ...

@final
class View:
    @property
    def address(self) -> str: ...
    @property
    def scene(self) -> str: ...
    def close(self) -> None: ...
