"""Pictures of datasets of xarray and uxarray."""

from __future__ import annotations

import html
import importlib
import os
import tempfile
import weakref
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from . import _icoray
from ._errors import ArgumentError
from ._icoray import Image, Renderer, Scene
from ._options import Facts, Look, Options, takes_options
from ._store import stores

if TYPE_CHECKING:
    from typing_extensions import Unpack

_SHORT = {
    "lon": ("camera", "lon"),
    "lat": ("camera", "lat"),
    "distance": ("camera", "distance"),
}
# Names of matplotlib and xarray, and those that they have here.
_SYNONYMS = {"cmap": "colormap", "level": "surface"}

_default: tuple[int, Renderer] | None = None


def _renderer() -> Renderer:
    """The renderer of calls that name none: one of this process."""
    global _default
    if _default is None or _default[0] != os.getpid():
        _default = (os.getpid(), Renderer())
    return _default[1]


class Dataset:
    """A dataset with its mesh, read and checked once; its fields are read when they are drawn.

    Parameters
    ----------
    data : xarray.Dataset, xarray.DataArray, uxarray.UxDataset, uxarray.UxDataArray, str or os.PathLike
        MPAS-Atmosphere, MPAS-Ocean, MPAS-Seaice, ICON, FESOM2, FVCOM, DYNAMICO or UGRID. A path (NetCDF, Zarr, GRIB)
        is opened by xarray; it may be a pattern such as ``"history.*.nc"``. Several files of one run, by a pattern or a sequence, are read as one by their
        dates, with fields in any of them.
    mesh : the same or uxarray.Grid, or a sequence of these
        What `data` lacks: the mesh, as in the run's init or grid file, or the heights of layers.
    at : mapping of str to int, optional
        Entry, from 0, that is read along a dimension beside columns, layers and time.
    heights : (float, float), optional
        Heights of the first and of the last layer, metres, instead of those of the dataset; those between are evenly
        spaced.
    radius : float, optional
        Radius of the sphere, metres, instead of that of the dataset.
    missing : sequence of float, optional
        Values that mark missing samples, beside those of attributes.

    Raises
    ------
    GridError
        Where no mesh is found, or a table of it is wrong; with the table, the row and the value.
    ArgumentError
        Where the dataset has no such dimension or entry, or a radius or heights are none.
    """

    def __init__(self, data: Any, mesh: Any = (), **facts: Unpack[Facts]) -> None:
        self._inner = _icoray.Dataset(*stores(data, mesh), **facts)

    @property
    def fields(self) -> dict[str, dict[str, Any]]:
        """All fields by name: long_name, units, location ("cell" or "corner"), layers (1 of a 2D field) and
        time_dependent."""
        return self._inner.fields

    @property
    def likely_fields(self) -> list[str]:
        """Names of the fields that are worth showing, the likeliest first."""
        return self._inner.likely_fields

    @property
    def times(self) -> list[str | None]:
        """The date of each time, None where there is none."""
        return self._inner.times

    @property
    def convention(self) -> str:
        """The kind of mesh: "MPAS", "ICON", "UGRID", "ESMF", "FESOM2", "FVCOM", "polygons" or "points" (columns)."""
        return self._inner.convention

    @property
    def cells(self) -> int:
        """Number of cells; of ICON the points of its triangles."""
        return self._inner.cells

    @property
    def corners(self) -> int:
        """Number of corners; of ICON its triangles."""
        return self._inner.corners

    @property
    def sphere_radius_m(self) -> float:
        """Radius of the sphere, metres."""
        return self._inner.sphere_radius_m

    def layer_heights(self, field: str) -> list[float]:
        """Heights of a field's layers, or of the interfaces between which it lies, metres above the sphere: means over
        all columns where these differ."""
        return self._inner.layer_heights(field)

    @takes_options
    def scene(
        self, field: str | None = None, *, renderer: Renderer | None = None, **options: Unpack[Options]
    ) -> Scene:
        """The scene that `render` draws with the same arguments, to be kept or changed."""
        return self._inner.scene(renderer or _renderer(), _request(field, options))

    @takes_options
    def render(
        self,
        field: str | None = None,
        *,
        renderer: Renderer | None = None,
        progress: bool | Callable[[int, int], object] = False,
        **options: Unpack[Options],
    ) -> Image:
        """Draws a picture. The arguments are those of `icoray.render`."""
        report, finish = _progress(progress)
        try:
            return self._inner.render(renderer or _renderer(), _request(field, options), report)
        finally:
            finish()

    @takes_options
    def animate(
        self,
        path: str | os.PathLike[str],
        field: str | None = None,
        *,
        times: Iterable[Any] | None = None,
        fps: float = 10.0,
        renderer: Renderer | None = None,
        **options: Unpack[Options],
    ) -> None:
        """Writes an animation of several times, as `icoray animate` does.

        Parameters
        ----------
        path : str or os.PathLike
            The animated PNG; or a film that ends in .mp4 or .gif, for which ffmpeg must be installed. An existing file
            is replaced.
        times : iterable, optional
            The times in their order, each as in `icoray.render`; all without it.
        fps : float
            Pictures per second, 0.001 to 1000.
        field, renderer, ...
            As in `icoray.render`. One scene is drawn at all times: without `scene` it is suggested for `time`, the last
            one without it.

        Examples
        --------
        >>> import icoray
        >>> icoray.open(icoray.sample()).animate("plume.png", "tracer", size=(80, 64), fps=2)
        """
        scene = self.scene(field, renderer=renderer, **options)
        drawn = list(range(len(self.times)) if times is None else times)
        with tempfile.TemporaryDirectory() as folder:
            pictures = [os.path.join(folder, f"{number}.png") for number in range(len(drawn))]
            for picture, time in zip(pictures, drawn, strict=True):
                image = self.render(scene=scene, time=time, layers=options.get("layers"), renderer=renderer)
                image.save(picture)
            _icoray.write_animation(path, pictures, fps)

    @takes_options
    def view(
        self,
        field: str | None = None,
        *,
        port: int | None = None,
        threads: int = 0,
        height: int = 640,
        **options: Unpack[Options],
    ) -> View:
        """Serves the live page. The arguments are those of `icoray.view`."""
        return View(self._inner.view(threads, _request(field, options), port), height)

    def __repr__(self) -> str:
        return repr(self._inner)

    def _repr_html_(self) -> str:
        likely = self.likely_fields
        names = [*likely, *(name for name in self.fields if name not in likely)]
        rows = "".join(_row(name, self.fields[name]) for name in names)
        head = "".join(f"<th>{title}</th>" for title in ("field", "long name", "units", "location", "layers", "times"))
        return f"<p>{html.escape(repr(self))}</p><table><tr>{head}</tr>{rows}</table>"


def _row(name: str, of: dict[str, Any]) -> str:
    """A field as a row of a table."""
    times = "all" if of["time_dependent"] else "one"
    cells = (name, of["long_name"] or "", of["units"] or "", of["location"], of["layers"], times)
    return "<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in cells) + "</tr>"


class View:
    """The live page of a dataset: a notebook shows it in a frame.

    The page is served on this machine's loopback address; from another machine it is reached through a forwarded port.
    It ends with `close`, with the `with` block, or with the interpreter.
    """

    def __init__(self, inner: Any, height: int) -> None:
        self._inner = inner
        self._height = height
        self.close = weakref.finalize(self, inner.close)

    @property
    def address(self) -> str:
        """The address of the page, with the token without which nothing is answered."""
        return str(self._inner.address)

    @property
    def scene(self) -> Scene:
        """The scene as it is shown now."""
        return Scene.parse(self._inner.scene)

    def __enter__(self) -> View:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        address = html.escape(self.address, quote=True)
        return (
            f'<iframe src="{address}" width="100%" height="{self._height}" style="border:0" allow="fullscreen"></iframe>'
            f'<p><a href="{address}" target="_blank" rel="noopener">{address}</a></p>'
        )

    def __repr__(self) -> str:
        return f"<icoray.View {self.address}>"


def open(data: Any, mesh: Any = (), **facts: Unpack[Facts]) -> Dataset:  # noqa: A001
    """Opens a dataset for several pictures: its mesh and the heights of layers are read once, fields for each picture.

    A loop is fastest with a scene (`Dataset.scene`), as a suggestion looks at all values of the field each time.

    Parameters
    ----------
    data, mesh, at, heights, radius, missing
        As in `Dataset`.

    Returns
    -------
    Dataset

    Examples
    --------
    >>> import icoray
    >>> ds = icoray.open(icoray.sample())
    >>> images = [ds.render("theta", time=t, size=(80, 64)) for t in range(len(ds.times))]
    >>> first, last = (icoray.sample().isel(Time=[t]) for t in (0, 1))
    >>> icoray.open([first, last]).times == ds.times
    True
    """
    return Dataset(data, mesh, **facts)


def sample() -> Any:
    """A dataset to try the package on: two vortices that wind up a plume.

    It has a mesh of MPAS of 2,562 cells, 16 layers up to 16 km, two times, and the fields `tracer`, `theta` (K) and
    `vorticity` (1/s). `icoray sample FILE.nc` writes it as a file.

    Returns
    -------
    xarray.Dataset
        In memory, its arrays its own.

    Raises
    ------
    ModuleNotFoundError
        Where xarray is not installed: ``pip install xarray``.

    Examples
    --------
    >>> import icoray
    >>> ds = icoray.sample()
    >>> ds.tracer.dims, dict(ds.sizes)["nCells"]
    (('Time', 'nCells', 'nVertLevels'), 2562)
    >>> icoray.render(ds, size=(320, 256)).pixels.shape
    (256, 320, 4)
    """
    xarray = importlib.import_module("xarray")
    return xarray.decode_cf(xarray.Dataset.from_dict(_icoray.sample()))


@takes_options
def render(
    data: Any,
    field: str | None = None,
    *,
    mesh: Any = (),
    renderer: Renderer | None = None,
    progress: bool | Callable[[int, int], object] = False,
    **options: Unpack[Options],
) -> Image:
    """Draws a picture of a dataset.

    Parameters
    ----------
    data : xarray.Dataset, xarray.DataArray, uxarray.UxDataset, uxarray.UxDataArray, str or os.PathLike
        MPAS-Atmosphere, MPAS-Ocean, MPAS-Seaice, ICON, FESOM2, FVCOM, DYNAMICO or UGRID, or several files of one run
        as in `Dataset`; or what `open` returned. Arrays of float32
        and float64 in memory are read where they are; what is loaded, computed (dask) or converted is counted in
        ``image.report["bytes_copied"]``.
    field : str, optional
        The field to draw; the likeliest one without it. A 2D field is drawn as a surface.
    mesh : the same or uxarray.Grid, or a sequence of these
        What `data` lacks: the mesh, as in the run's init or grid file, or the heights of layers.
    renderer : Renderer, optional
        What draws; without it one that is kept for the process.
    progress : bool or callable
        True shows a bar of tqdm; a callable gets the numbers of tiles that are drawn, and of all.
    time : int, str or date, optional
        Number from 0, negative from the last, or date. The last without it.
    layers : slice, (int, int) or str, optional
        The layers that are read and drawn, counted from 0.
    scene : Scene, str or os.PathLike, optional
        The scene to draw; without it a scene is suggested for the field's values. One that names a field alone, or
        to which `field` gives another, has the look of the suggestion.
    view : str, optional
        The one to draw of a scene with several [[views]].
    lon, lat : float, optional
        Degrees below the camera.
    distance : float, optional
        Of the camera from the planet's centre, planet radii.
    exaggeration : float, optional
        Factor on heights.
    colormap : str, optional
        Such as "viridis", "vik" or "rdylbu_r"; `cmap` is the same.
    range : (float, float), optional
        Values at the ends of the colour map; `vmin` and `vmax` together are the same.
    surface : int or str, optional
        Draw the values of a layer as a surface, in place of a volume: a number from 0, the innermost, "top" or "bottom".
        Its colours are set by `colormap` and `range`; `transfer` would draw a volume beside it. `level` is the same.
    isosurface : float, optional
        Draw the surface on which the field has this value, in place of a volume.
    size : (int, int), optional
        Width and height, pixels.
    tolerance : float, optional
        Largest error of a channel of a pixel.
    samples : int, optional
        Most rays per pixel, 1 to 64.
    exaggeration, background, core, transfer, light, labels, lines, ... : optional
        Keys of the scene, in place of its own: background="white", lines=[{"pattern": "graticule"}], ...

    Returns
    -------
    Image

    Raises
    ------
    Error
        Of the class that says what is wrong: GridError, FieldError, LayersError, SceneError, ArgumentError, ...
    TypeError
        For an argument by another name.

    Examples
    --------
    >>> import icoray
    >>> ds = icoray.sample()
    >>> image = icoray.render(ds, "theta", time=1, size=(320, 256), background="white")
    >>> image.save("theta.png")
    >>> ground = icoray.render(ds, "theta", level="bottom", cmap="plasma", vmin=260, vmax=320, size=(80, 64))
    >>> ground.to_rgba8().shape
    (64, 80, 4)
    """
    return _opened(data, mesh).render(field, renderer=renderer, progress=progress, **options)


@takes_options
def view(
    data: Any,
    field: str | None = None,
    *,
    mesh: Any = (),
    port: int | None = None,
    threads: int = 0,
    height: int = 640,
    **options: Unpack[Options],
) -> View:
    """Serves the live page of a dataset; a notebook shows it in a frame.

    Parameters
    ----------
    data, field, mesh
        As in `render`, as are further arguments.
    port : int, optional
        Port on this machine's loopback address; another one if it is taken.
    threads : int
        Number of rendering threads; 0 is the number of processors in this process's affinity mask.
    height : int
        Height of a notebook's frame, pixels.

    Returns
    -------
    View
    """
    return _opened(data, mesh).view(field, port=port, threads=threads, height=height, **options)


def _opened(data: Any, mesh: Any) -> Dataset:
    return data if isinstance(data, Dataset) else Dataset(data, mesh)


def _request(field: str | None, given: Options) -> dict[str, Any]:
    """The arguments of a call that are given; those that are keys of a scene by another name, as such."""
    options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    for synonym, name in _SYNONYMS.items():
        if synonym in options:
            _expect_one(options, synonym, name)
            options[name] = options.pop(synonym)
    ends = [name for name in ("vmin", "vmax") if name in options]
    for name in ends:
        _expect_one(options, name, "range")
    if len(ends) == 1:
        raise ArgumentError(f"{ends[0]}: {options[ends[0]]!r}, expected vmin and vmax together, or range=(low, high)")
    if ends:
        options["range"] = (options.pop("vmin"), options.pop("vmax"))
    # Options of the suggestion; all others are put into its scene.
    suggested = {"exaggeration", "tolerance", "samples"}
    keys = {name: options.pop(name) for name in Look.__annotations__ if name in options and name not in suggested}
    if field is not None:
        options["field"] = field
    if "scene" in options:
        for name, (table, key) in _SHORT.items():
            if name in options:
                keys[table] = {**keys.get(table, {}), key: options.pop(name)}
        keys |= {name: options.pop(name) for name in suggested if name in options}
        if "size" in options:
            width, height = options.pop("size")
            keys["image"] = {**keys.get("image", {}), "width": width, "height": height}
    if keys:
        options["keys"] = keys
    return options


def _expect_one(options: dict[str, Any], synonym: str, name: str) -> None:
    if name in options:
        raise ArgumentError(f"{synonym}: {options[synonym]!r}, expected no {synonym} beside {name}")


def _progress(
    progress: bool | Callable[[int, int], object],
) -> tuple[Callable[[int, int], object] | None, Callable[[], object]]:
    """The function that reports progress, and the one that ends the bar."""
    if progress is False:
        return None, lambda: None
    if progress is not True:
        if not callable(progress):
            raise ArgumentError(f"progress: {progress!r}, expected True, False or a function of two numbers")
        return progress, lambda: None
    try:
        tqdm = importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        return None, lambda: None
    bar = tqdm(unit=" tiles")

    def report(drawn: int, of: int) -> None:
        bar.total = of
        bar.update(drawn - bar.n)

    return report, bar.close

