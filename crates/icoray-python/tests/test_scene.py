"""Scenes of texts, files and keys."""

from __future__ import annotations

import itertools
import pathlib

import numpy as np
import pytest
from conftest import SCENE

import icoray

VIEWS = SCENE + """
[[views]]
name = "near"
camera = { distance = 2 }
[[views]]
name = "wide"
image = { width = 300 }
output = { file = "{view}_{step}.png" }
"""


def test_texts_files_and_keys_are_the_same_scene(tmp_path: pathlib.Path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    keys = icoray.Scene(
        field="q",
        exaggeration=np.float32(50),
        core="#3a4b5c",
        image={"width": np.int64(96), "height": 80},
        camera={"lon": 10, "lat": 20.0, "distance": 4, "fov": 40},
        transfer={"map": "viridis", "range": (0, 1), "opacity": np.array([[0, 0.0], [1, 0.9]])},
    )
    scenes = [icoray.Scene(SCENE), icoray.Scene.parse(SCENE), icoray.Scene(path), icoray.Scene(str(path)), keys]
    assert all(scene == scenes[0] for scene in scenes)
    assert scenes[0].to_toml() == SCENE and icoray.Scene(keys.to_toml()) == keys
    assert (keys.field, keys.fields, keys.width, keys.height) == ("q", ["q"], 96, 80)


def test_keys_stand_in_place_of_others():
    scene = icoray.Scene(SCENE, size=(64, 32), tolerance=1e-4)
    assert (scene.width, scene.height) == (64, 32) and "tolerance = 0.0001" in scene.to_toml()
    near = scene.replace(camera={"distance": 2})
    assert near != scene and near.replace(camera={"distance": 4}) == scene
    eye = scene.replace(camera={"eye": [3, 0, 0]})
    assert "lon" not in eye.to_toml(), "the eye goes in place of lon, lat and distance"
    assert scene.replace() == scene


def test_one_view_is_named():
    with pytest.raises(icoray.SceneError, match=r'the views \["near", "wide"\], expected one picture: .* view='):
        icoray.Scene(VIEWS)
    near, wide = icoray.Scene(VIEWS, view="near"), icoray.Scene.parse(VIEWS, view="wide")
    assert near == icoray.Scene(near.to_toml()) and wide.width == 300 and near.width == 96
    assert wide.replace(size=(100, 50)).width == 100
    with pytest.raises(icoray.SceneError, match=r'view "far", expected one of \["near", "wide"\]'):
        icoray.Scene(VIEWS, view="far")
    with pytest.raises(icoray.SceneError, match="2 pictures, expected one"):
        icoray.Scene(SCENE + "[sweep]\nlon = [0, 90]\n")


def test_wrong_scenes_are_refused(tmp_path: pathlib.Path):
    with pytest.raises(icoray.SceneError, match="line 2 .* unknown field `feild`.*did you mean `field`") as error:
        icoray.Scene("\nfeild = 'q'")
    assert error.value.kind == "scene"
    with pytest.raises(icoray.SceneError, match="key camera.lon: None, expected a number"):
        icoray.Scene(SCENE, camera={"lon": None})
    with pytest.raises(icoray.FileError, match="cannot read the scene"):
        icoray.Scene(tmp_path / "none.toml")
    path = tmp_path / "wrong.toml"
    path.write_text("field = 1")
    with pytest.raises(icoray.SceneError, match="wrong.toml: line 1"):
        icoray.Scene(path)


def test_a_renderer_takes_texts(renderer, grid, layers, wave, scene):
    one, other = (renderer.render(s, grid, layers, wave) for s in (SCENE, scene))
    np.testing.assert_array_equal(one.pixels, other.pixels)


class Itself:
    """An array that is its own list."""

    def tolist(self) -> "Itself":
        return self


def test_values_without_end_are_refused() -> None:
    table: dict = {"lon": 1}
    table["within"] = table
    items: list = []
    items.append(items)
    deep: dict = {}
    for _ in range(100_000):
        deep = {"within": deep}
    for value in (table, items, Itself(), deep):
        with pytest.raises(icoray.SceneError, match="key camera.*within each other, expected at most 16"):
            icoray.Scene(camera=value)
    with pytest.raises(icoray.SceneError, match="key field: more than 100000 items"):
        icoray.Scene(field=itertools.count())
