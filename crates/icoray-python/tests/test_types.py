"""The stubs against the module, and the examples in its documentation."""

from __future__ import annotations

import doctest
import pathlib
import subprocess
import sys

import pytest

import icoray
from icoray import _options


def test_examples_run(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("xarray", reason="xarray is not installed")
    monkeypatch.chdir(tmp_path)
    things = [icoray, *(getattr(icoray, name) for name in icoray.__all__ if name != "__version__")]
    members = [member for thing in things[1:] if isinstance(thing, type) for member in vars(thing).values()]
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner()
    for thing in [*things, *members]:
        runner.run(parser.get_doctest(getattr(thing, "__doc__", None) or "", {}, "icoray", None, 0))
    assert runner.failures == 0 and runner.tries > 20


def test_keys_are_those_of_scenes():
    with pytest.raises(icoray.SceneError, match="expected one of") as refused:
        icoray.Scene("no_such_key = 1")
    keys = str(refused.value).split("expected one of")[1].replace("`", "").split(", ")
    assert sorted(key.strip() for key in keys) == sorted(_options.Keys.__annotations__)


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
scene = icoray.Scene(field="q", transfer={"map": "vik"}).replace(tolerance=1e-4)
picture = icoray.render("a.nc", "q", cmap="vik", vmin=0, vmax=1, level="top", background="white", size=(3, 4))
turned = icoray.open("a.nc").render(lon=3.0, scene=scene)
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
    typos = {
        '"cell"': '"face"',
        "threads=1": "thread=1",
        "cmap=": "cmpa=",
        "lon=3.0": "lno=3.0",
        'transfer={"map"': 'tranfser={"map"',
        "tolerance=1e-4": "tolerance='small'",
    }
    wrong = USE
    for right, typo in typos.items():
        wrong = wrong.replace(right, typo)
    done = subprocess.run([*check, "-c", wrong], capture_output=True, text=True)
    assert f"Found {len(typos)} errors" in done.stdout, done.stdout
