"""Ranks of mpi4py against one process."""

from __future__ import annotations

import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import png_pixels

import icoray

MPIRUN = shutil.which("mpirun") or shutil.which("mpiexec")


def run(mode: str, ranks: int, directory: pathlib.Path) -> list[np.ndarray]:
    """The pictures of `ranks.py`."""
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    if MPIRUN is None:
        pytest.skip("no mpirun on the path")
    version = subprocess.run([MPIRUN, "--version"], capture_output=True, text=True).stdout
    options = ["--allow-run-as-root", "--oversubscribe"] if "Open MPI" in version or "OpenRTE" in version else []
    program = pathlib.Path(__file__).with_name("ranks.py")
    command = [MPIRUN, *options, "-n", str(ranks), sys.executable, str(program), mode, str(directory)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout.count("rank ") == ranks, done.stdout + done.stderr
    return [png_pixels(directory / f"q_{step}.png") for step in range(3)]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[np.ndarray]:
    return run("whole", 1, tmp_path_factory.mktemp("one"))


@pytest.mark.parametrize("mode", ["whole", "columns", "parts", "fortran", "async", "failure"])
@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_ranks_draw_the_picture_of_one(mode, ranks, expected, tmp_path):
    for picture, one in zip(run(mode, ranks, tmp_path), expected, strict=True):
        np.testing.assert_array_equal(picture, one)


def test_what_is_no_communicator_is_refused(tmp_path):
    mpi = pytest.importorskip("mpi4py")
    del mpi
    with pytest.raises(icoray.ArgumentError, match="expected a communicator"):
        icoray.Context(tmp_path, comm="world")


def test_ranks_need_mpi4py(tmp_path):
    program = """
    import sys
    sys.modules["mpi4py"] = None
    import icoray
    try:
        icoray.Context(comm=0)
    except icoray.UnsupportedError as error:
        print(error)
    """
    import textwrap

    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True)
    assert "comm= needs the package mpi4py" in done.stdout, done.stderr
