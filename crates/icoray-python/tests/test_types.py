"""The stubs against the module, and the examples in its documentation."""

from __future__ import annotations

import doctest
import pathlib
import subprocess
import sys

import pytest

import icoray


def test_examples_run(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("xarray", reason="xarray is not installed")
    monkeypatch.chdir(tmp_path)
    texts = [icoray.__doc__, *(getattr(icoray, name).__doc__ for name in icoray.__all__ if name != "__version__")]
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner()
    for text in texts:
        runner.run(parser.get_doctest(text or "", {}, "icoray", None, 0))
    assert runner.failures == 0 and runner.tries > 15


def test_everything_is_documented():
    for name in icoray.__all__:
        thing = getattr(icoray, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            assert member.startswith("_") or isinstance(value, str) or value.__doc__, f"{name}.{member}"


def test_stubs_are_those_of_the_module():
    pytest.importorskip("mypy", reason="mypy is not installed")
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "icoray"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


USE = """
import numpy as np
import icoray

grid = icoray.Grid.icosahedral(2)
layers = icoray.Layers.from_heights([0.0, 1e3], 6.371e6)
field = icoray.Field(np.zeros((162, 2)), "cell", units="K")
image = icoray.Renderer(threads=1).render(icoray.Scene("a.toml", size=(3, 4)), grid, layers, {"q": field})
seconds: float = image.report["render_s"]
with icoray.Context("out", comm=None) as context:
    context.execute(1, date="2026-11-24_00:00:00")
    rays: int = context.report()["rays"]
"""


def test_programs_are_checked(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    check = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run([*check, "-c", USE], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    wrong = USE.replace('"cell"', '"face"').replace("threads=1", "thread=1")
    done = subprocess.run([*check, "-c", wrong], capture_output=True, text=True)
    assert "Found 2 errors" in done.stdout, done.stdout
