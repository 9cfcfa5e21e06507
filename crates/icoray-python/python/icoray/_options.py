"""Arguments by name: the keys of scenes, and what `icoray.render` takes beside them."""

from __future__ import annotations

import difflib
import functools
import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, ParamSpec, TypedDict, TypeVar

if TYPE_CHECKING:
    import datetime

    import numpy as np

    from ._icoray import Scene

P = ParamSpec("P")
R = TypeVar("R")


class Facts(TypedDict, total=False):
    """Facts that a dataset may lack: arguments of `icoray.open`."""

    at: Mapping[str, int]
    heights: tuple[float, float]
    radius: float
    missing: Sequence[float]


class Look(TypedDict, total=False):
    """Keys of a scene that say what one picture shows, and how; the scene reference has their meaning."""

    exaggeration: float | None
    background: str | None
    core: str | None
    method: Literal["exact", "paper"] | None
    tolerance: float | None
    antialias: bool | None
    samples: int | None
    time_budget_ms: float | None
    precision: Literal["f32", "f64"] | None
    backend: Literal["auto", "cpu", "gpu"] | None
    device: int | str | None
    heights: Literal["mean", "native"] | None
    image: Mapping[str, Any] | None
    camera: Mapping[str, Any] | None
    transfer: Mapping[str, Any] | None
    opacity: Mapping[str, Any] | None
    volumes: Sequence[Mapping[str, Any]] | None
    surfaces: Sequence[Mapping[str, Any]] | None
    isosurfaces: Sequence[Mapping[str, Any]] | None
    lines: Sequence[Mapping[str, Any]] | None
    ground: Mapping[str, Any] | None
    clip: Sequence[Mapping[str, Any]] | None
    derive: Sequence[Mapping[str, Any]] | None
    light: Mapping[str, Any] | None
    labels: Mapping[str, Any] | None


class Keys(Look, total=False):
    """All keys of a scene."""

    field: str | None
    every: int | None
    at_steps: Sequence[int] | None
    at_times: Sequence[float] | None
    when: str | Sequence[str] | None
    ranks: Literal["auto", "tiles", "fragments"] | None
    async_render: bool | None
    output: Mapping[str, Any] | None
    views: Sequence[Mapping[str, Any]] | None
    sweep: Mapping[str, Any] | None
    live: Mapping[str, Any] | None


class Options(Look, total=False):
    """Arguments by name of a picture of a dataset, which `icoray.render` describes."""

    time: int | str | datetime.datetime | np.datetime64 | None
    layers: slice | tuple[int | None, int | None] | str | None
    scene: Scene | str | os.PathLike[str] | None
    view: str | None
    lon: float | None
    lat: float | None
    distance: float | None
    colormap: str | None
    cmap: str | None
    range: tuple[float, float] | Sequence[float] | None
    vmin: float | None
    vmax: float | None
    surface: int | str | None
    level: int | str | None
    isosurface: float | None
    size: tuple[int, int] | Sequence[int] | None


def takes_options(function: Callable[P, R]) -> Callable[P, R]:
    """A function with `**options`, whose signature has the names of `Options`, for `help` and completion, and which
    refuses others."""
    signature = inspect.signature(function)
    own = [known for known in signature.parameters.values() if known.kind is not known.VAR_KEYWORD]
    named = inspect.Parameter.KEYWORD_ONLY
    options = [
        inspect.Parameter(name, named, default=None, annotation=annotation.__forward_arg__)
        for name, annotation in Options.__annotations__.items()
    ]

    @functools.wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        names = expanded.parameters
        for name in kwargs:
            if name not in names:
                near = difflib.get_close_matches(name, names, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise TypeError(f"{function.__name__}() got an unexpected keyword argument {name!r}{hint}")
        return function(*args, **kwargs)

    expanded = signature.replace(parameters=[*own, *options])
    checked.__signature__ = expanded  # type: ignore[attr-defined]
    return checked
