"""Errors, a class for each kind that the library knows."""


class Error(Exception):
    """The base class of icoray's errors; the message names the table, row or key, the value, and the expected one."""

    kind: str = "error"


class ArgumentError(Error, ValueError):
    """An argument is out of its range."""

    kind = "argument"


class GridError(Error, ValueError):
    """A table contradicts itself or another one."""

    kind = "grid"


class UnsupportedError(Error, NotImplementedError):
    """The mesh is of a kind that is not rendered, or something needed is not installed."""

    kind = "unsupported"


class LayersError(Error, ValueError):
    """Radii are not positive, finite and strictly monotone, or heights of columns are wrong."""

    kind = "layers"


class FieldError(Error, ValueError):
    """A field is missing, or does not fit grid and layers."""

    kind = "field"


class SceneError(Error, ValueError):
    """The scene is wrong; the message has line and key."""

    kind = "scene"


class OrderError(Error, RuntimeError):
    """A call that must come before is missing."""

    kind = "order"


class FileError(Error, OSError):
    """A file could not be read or written."""

    kind = "io"


class ExistsError(Error, FileExistsError):
    """The picture exists and is not replaced."""

    kind = "exists"


class InternalError(Error, RuntimeError):
    """A bug in icoray."""

    kind = "internal"


class MpiError(Error, RuntimeError):
    """MPI failed, or ranks differ in call, step, scene or data."""

    kind = "mpi"


class OutOfMemoryError(Error, MemoryError):
    """A grid or a frame needs more memory than there is."""

    kind = "memory"


class DisabledError(Error, RuntimeError):
    """The context has switched itself off after too many failures."""

    kind = "disabled"


class BusyError(Error, RuntimeError):
    """Another call on the context, or another frame of this thread, has not returned yet."""

    kind = "busy"


class ForkedError(Error, RuntimeError):
    """The object was made before this process was forked, and its threads are not here."""

    kind = "forked"
