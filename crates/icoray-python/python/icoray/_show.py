"""Shows pictures on the screen."""

from __future__ import annotations

import pathlib
import sys
import tempfile
import webbrowser
from typing import TYPE_CHECKING

from ._errors import UnsupportedError

if TYPE_CHECKING:
    from ._icoray import Image


def show(image: Image) -> None:
    """Shows a picture: a notebook below the cell, elsewhere the program that opens PNGs, which reads a temporary file
    when it likes, so that the file is not deleted here."""
    notebook = sys.modules.get("IPython")
    shell = notebook and notebook.get_ipython()
    if notebook and hasattr(shell, "kernel"):
        notebook.display.display(image)
        return
    with tempfile.NamedTemporaryFile(prefix="icoray-", suffix=".png", delete=False) as file:
        file.write(image._repr_png_())
    if not webbrowser.open(pathlib.Path(file.name).as_uri()):
        raise UnsupportedError(f"no program here shows pictures; {file.name} is the picture, save writes it elsewhere")
