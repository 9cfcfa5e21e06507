"""One of VTK's volume renderers on explicit wedges or tetrahedra, for `icoray-study vtk`.

    draw.py DIRECTORY RENDERER THREADS FRAMES MEMORY_BYTES PICTURE

reads the model that the study has written, prints `name value` lines, and writes linear RGB as f32, rows from the top.
Memory counts from after the arrays are read: they stand for the model's own.
"""

import resource
import sys
import time
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray


def memory(what):
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(what):
            return 1024 * int(line.split()[1])
    raise SystemExit(f"/proc/self/status has no {what}")


def read(directory):
    """Numbers of the scene, unit vectors of cells, radii, cells of triangles, values.

    In a unit of length that makes the largest extinction 1: projected tetrahedra hold it in 8 bits.
    """
    scene = {}
    for line in (directory / "scene.txt").read_text().splitlines():
        name, *numbers = line.split()
        scene.setdefault(name, []).append([float(n) for n in numbers])
    directions = np.fromfile(directory / "directions.f64").reshape(-1, 3)
    triangles = np.fromfile(directory / "triangles.i32", dtype=np.int32).reshape(-1, 3)
    values = np.fromfile(directory / "values.f32", dtype=np.float32)
    unit = max(knot[-1] for knot in scene["knot"])
    scene["eye"][0] = [unit * x for x in scene["eye"][0]]
    for knot in scene["knot"]:
        knot[-1] /= unit
    return scene, directions, unit * np.array(scene["radii"][0]), triangles, values


def wedges(directions, radii, triangles, values):
    """The explicit grid: a wedge for each triangle between two layers, level by level over a column's points."""
    layers = len(radii)
    points = (directions[:, None, :] * radii[None, :, None]).reshape(-1, 3).astype(np.float32)
    corners = directions[triangles]
    outward = np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0])
    # VTK wants the first triangle's normal to point away from the second one, inwards.
    turned = np.where((outward > 0)[:, None], triangles[:, [0, 2, 1]], triangles).astype(np.int64)
    base = (turned * layers)[:, None, :] + np.arange(layers - 1)[None, :, None]
    connectivity = np.concatenate([base, base + 1], axis=2).reshape(-1, 6)
    grid = vtk.vtkUnstructuredGrid()
    grid_points = vtk.vtkPoints()
    grid_points.SetData(numpy_to_vtk(points, deep=True))
    grid.SetPoints(grid_points)
    cells = vtk.vtkCellArray()
    offsets = numpy_to_vtkIdTypeArray(np.arange(0, 6 * len(connectivity) + 1, 6), deep=True)
    cells.SetData(offsets, numpy_to_vtkIdTypeArray(connectivity.ravel(), deep=True))
    grid.SetCells(vtk.VTK_WEDGE, cells)
    scalars = numpy_to_vtk(values, deep=True)
    scalars.SetName("f")
    grid.GetPointData().SetScalars(scalars)
    return grid


def tetrahedra(grid):
    split = vtk.vtkDataSetTriangleFilter()
    split.SetInputData(grid)
    split.Update()
    return split.GetOutput()


def timed(window, frames, prepare=lambda: None):
    seconds = []
    for _ in range(frames):
        prepare()
        start = time.perf_counter()
        window.Render()
        window.WaitForCompletion()
        seconds.append(time.perf_counter() - start)
    return seconds


def mapper_of(renderer, threads):
    if renderer == "projected-tetrahedra":
        return vtk.vtkProjectedTetrahedraMapper()
    if renderer == "zsweep":
        mapper = vtk.vtkUnstructuredGridVolumeZSweepMapper()
    else:
        mapper = vtk.vtkUnstructuredGridVolumeRayCastMapper()
        mapper.SetNumberOfThreads(threads)
    mapper.SetAutoAdjustSampleDistances(False)
    mapper.SetImageSampleDistance(1.0)
    return mapper


def window_of(scene, volume):
    width, height = (int(n) for n in scene["size"][0])
    camera = vtk.vtkCamera()
    eye, forward, up = (np.array(scene[name][0]) for name in ("eye", "forward", "up"))
    camera.SetPosition(*eye)
    camera.SetFocalPoint(*(eye + forward))
    camera.SetViewUp(*up)
    camera.SetViewAngle(2.0 * np.degrees(np.arctan(scene["half_height"][0][0])))
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0.0, 0.0, 0.0)
    renderer.AddVolume(volume)
    renderer.SetActiveCamera(camera)
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(width, height)
    window.AddRenderer(renderer)
    return window


def property_of(scene):
    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    # Knots of one function that the other has not are dropped by the ray casters, so both have all.
    for value, red, green, blue, extinction in scene["knot"]:
        color.AddRGBPoint(value, red, green, blue)
        opacity.AddPoint(value, extinction)
    looks = vtk.vtkVolumeProperty()
    looks.SetColor(color)
    looks.SetScalarOpacity(opacity)
    looks.SetScalarOpacityUnitDistance(1.0)
    looks.SetInterpolationTypeToLinear()
    looks.ShadeOff()
    return looks


def picture(window):
    """What the window shows, without drawing it again."""
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGB()
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    data = np.frombuffer(memoryview(image.GetPointData().GetScalars()), dtype=np.uint8)
    return (data.reshape(height, width, 3)[::-1] / np.float32(255)).astype(np.float32)


def main():
    directory, renderer, threads, frames, limit, target = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_DATA, (int(limit), int(limit)))
    scene, *model = read(Path(directory))
    Path("/proc/self/clear_refs").write_text("5")
    before = memory("VmRSS")
    start = time.perf_counter()
    grid = wedges(*model)
    print("wedges", grid.GetNumberOfCells())
    if renderer != "zsweep":
        grid = tetrahedra(grid)
    mapper = mapper_of(renderer, int(threads))
    mapper.SetInputData(grid)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(property_of(scene))
    window = window_of(scene, volume)
    print("build_s", time.perf_counter() - start)
    seconds = timed(window, int(frames))
    print("first_s", seconds[0])
    print("frame_s", min(seconds[1:], default=seconds[0]))
    # A model's next step: other values on the same mesh.
    print("step_s", min(timed(window, int(frames), grid.GetPointData().GetScalars().Modified)))
    picture(window).tofile(target)
    print("memory", memory("VmHWM") - before)
    print("version", vtk.VTK_VERSION)


main()
