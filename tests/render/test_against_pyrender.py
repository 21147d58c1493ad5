"""Our OpenGL against somebody else's: pyrender draws the same mesh in its own process."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapes

from abs_engine.core.geometry import Pose

pytestmark = pytest.mark.gl

PIXELS = 96


def egl_loads() -> bool:
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    return True


@pytest.fixture(scope="module")
def drawn_by_pyrender(gl, tmp_path_factory):
    """The scene, a state, and pyrender's ids and depth; without a GPU's own rounding."""
    folder = tmp_path_factory.mktemp("pyrender")
    scene = shapes.ball(2, 4)
    camera, _ = shapes.view(PIXELS)
    state = shapes.states(scene, 1, seed=11)
    pose = Pose(state.rotations[0], state.translations[0])
    np.savez(
        folder / "in.npz",
        vertices=pose.apply(scene.vertices(state.weights[0])),
        faces=scene.faces,
        matrix=camera.matrix,
        size=camera.size,
        near=camera.near,
        far=camera.far,
    )
    worker = Path(__file__).parents[1] / "pyrender_worker.py"
    done = subprocess.run(
        [sys.executable, str(worker), str(folder / "in.npz"), str(folder / "out.npz")],
        env={
            **os.environ,
            "PYOPENGL_PLATFORM": "egl" if egl_loads() else "osmesa",
            "PYGLET_HEADLESS": "1",  # without X11's libraries pyglet loads no other way
        },
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    out = np.load(folder / "out.npz")
    return scene, camera, state, out["ids"], out["depth"]


def beside_an_edge(ids):
    """Pixels whose 3x3 neighbourhood holds more than one id."""
    padded = np.pad(ids, 1, mode="edge")
    shifted = [
        padded[1 + dy : 1 + dy + ids.shape[0], 1 + dx : 1 + dx + ids.shape[1]]
        for dy in (-1, 0, 1)
        for dx in (-1, 0, 1)
    ]
    return np.any([part != ids for part in shifted], axis=0)


def test_ids_and_coverage(renderer, drawn_by_pyrender):
    scene, camera, state, ids, _ = drawn_by_pyrender
    seen = renderer.draw(scene, state, camera, camera.whole)[0]
    assert (ids > 0).sum() > 0.5 * PIXELS**2
    wrong = seen.facet_id != ids
    assert wrong.sum() <= 5  # its matrices are float32
    assert not (wrong & ~beside_an_edge(ids)).any()
    assert ((seen.facet_id > 0) != (ids > 0)).sum() <= 2


def test_depth(renderer, drawn_by_pyrender):
    scene, camera, state, ids, depth = drawn_by_pyrender
    seen = renderer.draw(scene, state, camera, camera.whole)[0]
    same = (seen.facet_id == ids) & (ids > 0)
    # Half a pixel's error of position would show: the surface falls 3 mm and more per pixel there.
    assert np.abs(seen.depth - depth)[same].max() < 0.1
    assert np.abs(seen.depth - depth)[same].mean() < 0.01
