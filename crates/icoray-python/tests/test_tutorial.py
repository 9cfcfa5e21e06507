"""The book's tutorial: its notebook is what the page says, and runs with the real data.

`ICORAY_WRITE_TUTORIAL=1` writes the notebook anew. The notebook is run where its data file is found, and where
nbclient, ipykernel and what it imports are installed. ICORAY_REQUIRE makes a failure of what is missing: `data` of the
file, `python` of the packages, `all` of both.
"""

from __future__ import annotations

import base64
import importlib.util
import io
import os
import pathlib
import socket
from typing import Any

import numpy as np
import pytest
import tutorial
from conftest import PATIENCE, data_file, lacks

import icoray

FILE = "mpas_jw_10242.nc"
PACKAGES = ("nbclient", "nbformat", "ipykernel", "matplotlib", "PIL", "xarray", "uxarray", "dask")
SIZE = (640, 480)


def test_the_notebook_is_the_page():
    made = tutorial.notebook(tutorial.PAGE.read_text())
    if os.environ.get("ICORAY_WRITE_TUTORIAL") == "1":
        tutorial.NOTEBOOK.write_text(made)
    assert tutorial.NOTEBOOK.read_text() == made, "ICORAY_WRITE_TUTORIAL=1 writes it anew"


def test_cells_are_the_blocks_of_the_page():
    page = "# Title\n\ntext\n\n```python\nx = 1\n\nx\n```\n\n![a picture](a.png)\n\nmore\n\n```text\n!\n```\n"
    code = ("code", "x = 1\n\nx")
    assert tutorial.cells(page) == [("markdown", "# Title\n\ntext"), code, ("markdown", "more\n\n```text\n!\n```")]


class Run:
    """The executed notebook."""

    def __init__(self, cells: list[Any], folder: pathlib.Path) -> None:
        self.cells = [cell for cell in cells if cell.cell_type == "code"]
        self.folder = folder

    def cell(self, part: str) -> Any:
        """The cell whose code has this part."""
        (found,) = (cell for cell in self.cells if part in cell.source)
        return found

    def text(self, part: str) -> str:
        """What a cell has printed."""
        return "".join(output.text for output in self.cell(part).outputs if output.output_type == "stream")

    def shown(self, part: str) -> Any:
        """The picture that a cell shows."""
        pngs = [output.data["image/png"] for output in self.cell(part).outputs if "image/png" in output.get("data", {})]
        assert len(pngs) == 1, part
        return picture(io.BytesIO(base64.b64decode(pngs[0])))


def picture(file: Any) -> Any:
    from PIL import Image

    image = Image.open(file)
    image.load()
    return image


def colours(image: Any) -> int:
    return len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = pathlib.Path(data_file(FILE)).parent
    lacking = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if lacking:
        lacks("python", f"not installed: {', '.join(lacking)}")
    import nbformat
    from ipykernel.kernelspec import write_kernel_spec
    from nbclient import NotebookClient

    book = nbformat.reads(tutorial.NOTEBOOK.read_text(), as_version=4)
    nbformat.validate(book)
    where = tmp_path_factory.mktemp("tutorial")
    # The kernel of this interpreter comes before all that are installed under its name.
    kernels = tmp_path_factory.mktemp("jupyter")
    write_kernel_spec(kernels / "kernels/python3")
    client = NotebookClient(book, kernel_name="python3", timeout=PATIENCE, resources={"metadata": {"path": str(where)}})
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("ICORAY_TEST_DATA", str(folder.resolve()))
        environment.setenv("JUPYTER_PATH", str(kernels))
        environment.delenv("MPLBACKEND", raising=False)
        # An error of a cell is raised here, with its traceback.
        client.execute()
    return Run(book.cells, where)


def test_no_cell_warns(run):
    streams = [output for cell in run.cells for output in cell.outputs if output.output_type == "stream"]
    assert [output.text for output in streams if output.name != "stdout"] == []


@pytest.mark.parametrize(
    ("part", "size"),
    [
        ("first = dataset.render", SIZE),
        ('picture = dataset.render("vorticity"', SIZE),
        ('scene="vorticity.toml"', (320, 240)),
        ('surface="bottom"', (480, 360)),
        ("difference = icoray.render", SIZE),
        ("import uxarray", SIZE),
        ("chunks=", (480, 360)),
        ("page.close()", SIZE),
    ],
)
def test_pictures_are_shown(run, part, size):
    shown = run.shown(part)
    assert shown.size == size
    assert colours(shown) > 1000


@pytest.mark.parametrize("part", ["axes.hist", "layer_heights", "error_map", "orbit = "])
def test_figures_are_shown(run, part):
    assert run.shown(part).width > 400


@pytest.mark.parametrize("name", ["vorticity.png", "difference.png"])
def test_pictures_are_saved(run, name):
    saved = picture(run.folder / name)
    assert (saved.format, saved.size) == ("PNG", SIZE)
    assert saved.info["Software"].startswith("icoray")


def test_the_map_of_errors_is_saved(run):
    width, height = picture(run.folder / "error.png").size
    # A scale of colours is below the map.
    assert width == SIZE[0] and height > SIZE[1]


def test_the_animation_has_all_frames(run):
    film = picture(run.folder / "wave.png")
    assert (film.format, film.size, film.n_frames) == ("PNG", (320, 240), 24)
    frames = []
    for number in range(film.n_frames):
        film.seek(number)
        frames.append(np.asarray(film.convert("RGB"), float))
    assert all(np.abs(a - b).mean() > 0.1 for a, b in zip(frames, frames[1:]))


def test_arrays_in_memory_are_not_copied(run):
    copied = {line[:12].strip(): int(line[12:].split()[0]) for line in run.text("chunks=").splitlines()[:3]}
    assert copied["in memory"] == 0
    assert copied["in the file"] > 10242 * 26 * 4 and copied["dask"] == copied["in the file"]
    assert "copied   0 bytes" in run.text("report = first.report")


def test_errors_are_reported(run):
    said = run.text("vorticty")
    assert "there is no field vorticty" in said and 'did you mean "vik"?' in said
    surface, volume = (float(word) for word in run.text("error_map").split()[1::2])
    assert surface < 1e-5 < volume < 1e-3


def test_uxarray_gives_the_same_picture(run):
    assert float(run.text("import uxarray").split()[-1]) < 1e-4


def test_the_live_page_is_shown(run):
    (output,) = run.cell("page = dataset.view").outputs
    assert output.data["text/html"].startswith('<iframe src="http://127.0.0.1:')
    # Its scene draws the picture that was shown before.
    before, after = run.shown('picture = dataset.render("vorticity"'), run.shown("page.close()")
    np.testing.assert_array_equal(np.asarray(before), np.asarray(after))


def test_a_closed_page_does_not_answer():
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    page = icoray.view(xarray.open_dataset(data_file(FILE)), "theta")
    host, port = page.address.split("//")[1].split("/")[0].split(":")
    socket.create_connection((host, int(port)), timeout=5).close()
    page.close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((host, int(port)), timeout=5).close()
