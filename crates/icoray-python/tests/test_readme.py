"""The lines of README.md."""

from __future__ import annotations

import pathlib

import pytest

from conftest import data_file, png_pixels

README = pathlib.Path(__file__).resolve().parents[3] / "README.md"


@pytest.mark.parametrize(("name", "field"), [("mpas_jw_10242.nc", "theta"), ("psyplot_icon_test.nc", "t2m")])
def test_three_lines_draw_a_picture(name: str, field: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("xarray", reason="xarray is not installed")
    (tmp_path / name).symlink_to(data_file(name))
    monkeypatch.chdir(tmp_path)
    lines = README.read_text().split("```python\n")[1].split("```")[0]
    assert len(lines.splitlines()) == 3
    if name != "mpas_jw_10242.nc":
        lines = lines.replace("mpas_jw_10242.nc", name).replace('"theta", time=2', f'"{field}", time=1')
    exec(compile(lines, "README.md", "exec"), {})
    pixels = png_pixels(tmp_path / "theta.png")
    assert pixels.shape[:2] > (400, 400) and pixels[..., :3].std() > 20
