"""Threads, signals and forks."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import textwrap
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import PATIENCE, SCENE

import icoray


def test_threads_draw_with_their_own_renderers_and_with_one(scene, grid, layers, wave):
    shared = icoray.Renderer(1)
    fields = [wave * factor for factor in np.linspace(0.2, 1, 6)]
    expected = [shared.render(scene, grid, layers, field).pixels for field in fields]
    for renderers in ([shared] * 6, [icoray.Renderer(1) for _ in fields]):
        with ThreadPoolExecutor(6) as threads:
            frames = [threads.submit(r.render, scene, grid, layers, f) for r, f in zip(renderers, fields)]
            for frame, pixels in zip(frames, expected):
                np.testing.assert_array_equal(frame.result().pixels, pixels)


def test_the_lock_is_released_while_rays_are_traced(without_preemption, grid, layers, wave):
    scene = icoray.Scene(SCENE, size=(1024, 1024), tolerance=1e-6)
    started, done = threading.Event(), threading.Event()

    def draw():
        renderer = icoray.Renderer(1)
        started.set()
        renderer.render(scene, grid, layers, wave)
        done.set()

    thread = threading.Thread(target=draw)
    thread.start()
    started.wait()
    # This thread runs as the other one has released the lock, which nothing else makes it do before it has drawn.
    assert not done.is_set()
    thread.join()


def test_of_two_arrays_that_threads_set_the_one_that_is_kept_is_drawn(tmp_path: pathlib.Path, grid, layers, wave):
    begin = threading.Barrier(2)
    arrays: dict[float, weakref.ref] = {}

    def set_one(context: icoray.Context, value: float) -> None:
        array = np.full_like(wave, value)
        arrays[value] = weakref.ref(array)
        begin.wait()
        try:
            context.field_set("q", array)
        except icoray.BusyError:
            pass

    with icoray.Context(tmp_path, SCENE, threads=1) as context:
        context.grid_set(grid)
        context.layers_set(layers)
        for step in range(200):
            threads = [threading.Thread(target=set_one, args=(context, 2.0 * step + one)) for one in range(2)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            context.execute(step)
            kept = [value for value, array in arrays.items() if array() is not None]
            assert kept == [context.report()["value_max"]], step


INTERRUPT = """
import os, signal, sys, threading
import numpy as np
import icoray

grid = icoray.Grid.icosahedral(4)
layers = icoray.Layers.from_heights([0.0, 5e4, 1e5], 6.371e6)
wave = np.random.default_rng(1).random((grid.cells, 3))
scene = icoray.Scene(
    field="q", size=(64, 64), camera={"lon": 0, "lat": 0, "distance": 3},
    transfer={"map": "viridis", "range": [0, 1], "opacity": [[0, 0.0], [1, 0.1]]},
)
# Far more work than a test may take.
long = scene.replace(size=(8192, 8192), tolerance=1e-7, precision="f64")
renderer = icoray.Renderer(2)
expected = renderer.render(scene, grid, layers, wave).pixels
go = threading.Event()

def interrupt():
    go.wait()
    os.kill(os.getpid(), signal.SIGINT)

thread = threading.Thread(target=interrupt)
thread.start()
# The lock is handed over where `render` releases it, so the signal comes while it draws.
sys.setswitchinterval(1e3)
go.set()
try:
    renderer.render(long, grid, layers, wave)
except KeyboardInterrupt:
    sys.setswitchinterval(0.005)
    thread.join()
    again = renderer.render(scene, grid, layers, wave).pixels
    print("interrupted, and", "equal" if (again == expected).all() else "different")
"""


def test_ctrl_c_ends_a_frame_and_the_renderer_goes_on():
    done = subprocess.run([sys.executable, "-c", INTERRUPT], capture_output=True, text=True, timeout=PATIENCE)
    assert done.stdout == "interrupted, and equal\n", done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_forked_renderer_is_refused():
    program = f"""
    import os, icoray
    renderer = icoray.Renderer(1)
    grid, layers = icoray.Grid.icosahedral(1), icoray.Layers([1.0, 1.1], 1.0)
    if os.fork() == 0:
        try:
            renderer.render({SCENE!r}, grid, layers, [[0.0, 1.0]] * 42)
        except icoray.ForkedError as error:
            assert error.kind == "forked", error
            icoray.Renderer(1).render({SCENE!r}, grid, layers, [[0.0, 1.0]] * 42)
            os._exit(7)
        os._exit(1)
    print(os.waitstatus_to_exitcode(os.wait()[1]))
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True)
    assert done.stdout == "7\n", done.stderr
