"""The lines of README.md."""

from __future__ import annotations

import pathlib

import pytest

from conftest import data_file, png_pixels

README = pathlib.Path(__file__).resolve().parents[3] / "README.md"


@pytest.mark.parametrize(
    ("name", "arguments"),
    [(None, ""), ("mpas_jw_10242.nc", '"theta", time=2'), ("psyplot_icon_test.nc", '"t2m", time=1')],
)
def test_three_lines_draw_a_picture(
    name: str | None, arguments: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    monkeypatch.chdir(tmp_path)
    lines = README.read_text().split("```python\n")[1].split("```")[0]
    assert len(lines.splitlines()) == 3
    if name is not None:
        opened = f'xarray.open_dataset("{data_file(name)}")'
        lines = lines.replace("icoray.sample()", opened).replace('"theta", time=1', arguments)
        assert f"{opened}, {arguments}" in lines
    exec(compile(lines, "README.md", "exec"), {"xarray": xarray})
    pixels = png_pixels(tmp_path / "theta.png")
    assert pixels.shape[:2] > (400, 400) and pixels[..., :3].std() > 20
