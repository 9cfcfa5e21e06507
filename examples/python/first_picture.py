"""Pictures of a dataset of a model on a geodesic grid: a suggested one, one of a scene, and one of each time.

    python first_picture.py                     draws a small dataset that the script makes
    python first_picture.py history.nc theta    draws a field of a file of MPAS, ICON or UGRID

The pictures go to the folder `pictures`. The script needs the packages icoray and xarray, and netCDF4 to read a file.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr

import icoray

PICTURES = Path("pictures")


def made_dataset() -> xr.Dataset:
    """Temperature anomalies on 20,480 triangles and 12 heights at four times, as ICON writes them.

    A wave of five warm and cold air masses drifts eastwards along the jet of each hemisphere.
    """
    grid = icoray.Grid.icosahedral(5)
    lon, lat = np.asarray(grid.lon_corner_rad), np.asarray(grid.lat_corner_rad)
    points = np.asarray(grid.corner_cell)  # the three points of each triangle
    height = np.linspace(500.0, 17000.0, 12)
    days = np.arange(4)

    day, level = days[:, None, None], height[None, :, None]
    jet = np.exp(-(((np.abs(lat) - np.radians(45)) / np.radians(12)) ** 2))
    # Air masses lean westwards with height.
    wave = np.cos(5 * (lon - np.radians(12) * day + np.radians(15) * level / 17000))
    values = 12 * jet * wave * np.exp(-(((level - 8000) / 5000) ** 2))
    return xr.Dataset(
        {"anomaly": (("time", "height", "cell"), values, {"units": "K", "long_name": "temperature anomaly"})},
        coords={
            "time": np.datetime64("2026-01-01", "ns") + days * np.timedelta64(1, "D"),
            "height": ("height", height, {"units": "m"}),
            "clon": ("cell", lon, {"units": "radian", "bounds": "clon_bnds"}),
            "clat": ("cell", lat, {"units": "radian", "bounds": "clat_bnds"}),
            "clon_bnds": (("cell", "vertices"), np.asarray(grid.lon_center_rad)[points]),
            "clat_bnds": (("cell", "vertices"), np.asarray(grid.lat_center_rad)[points]),
        },
    )


def main(path: str | None = None, field: str | None = None) -> None:
    dataset = icoray.open(xr.open_dataset(path) if path else made_dataset())
    field = field or dataset.likely_fields[0]
    print(f"{dataset}\n{field} at {dataset.times}")
    PICTURES.mkdir(exist_ok=True)

    # Without a scene, the values decide on colours, opacities and the camera.
    image = dataset.render(field)
    image.save(PICTURES / "suggested.png")
    print("largest error of a channel:", image.report["error_max"])

    # The suggested scene with other keys; docs/src/scene-reference.md lists them. `icoray render` and models read the
    # file too.
    scene = dataset.scene(field, size=(640, 480), lat=65, distance=4.2, background="#0b1020")
    Path(PICTURES / "scene.toml").write_text(scene.to_toml())
    dataset.render(scene=scene, time=0).save(PICTURES / "scene.png")

    # The scene fixes colours and opacities, so that the pictures of all times can be compared.
    for time, date in enumerate(dataset.times):
        image = dataset.render(scene=scene, time=time)
        image.save(PICTURES / f"time_{time}.png")
        print(date, f"{image.report['render_s']:.2f} s")


if __name__ == "__main__":
    main(*sys.argv[1:3])
