"""An inspection picture: a bundled person in a posture of face units."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker, load_speaker
from abs_engine.camera import Camera, Window
from abs_engine.errors import ParameterError
from abs_engine.geometry import Pose
from abs_engine.scene import Candidates, Renderer, Scene
from abs_engine.synth.sequence import portrait

SAMPLES = 3  # drawn pixels a side for each pixel of the picture
BACKGROUND = (70, 76, 82)
CLASS_COLOURS = np.array(
    [BACKGROUND, (222, 184, 160), (200, 60, 70), (240, 110, 100), (70, 30, 40),
     (250, 250, 235), (205, 215, 235), (230, 130, 170), (90, 170, 230)],
    np.uint8,
)  # fmt: skip


def draw_portrait(
    renderer: Renderer,
    person: str,
    units: Mapping[str, float],
    *,
    size: tuple[int, int] = (512, 512),
    palette: str = "colour",
    turn: float = 0.0,
) -> NDArray[np.uint8]:
    """Draw a person.

    Parameters
    ----------
    renderer : Renderer
    person : str
    units : mapping of str to float
        Weights of face units.
    size : tuple of int
        Width and height, pixels.
    palette : {"colour", "classes"}
        The texture, or one colour for each facet class.
    turn : float
        Degrees by which the head turns to its left.

    Returns
    -------
    (H, W, 3) uint8 RGB

    Raises
    ------
    ParameterError
        If there is no such person or face unit.
    """
    speaker, camera = load_speaker(), Camera.ideal(size)
    scene = _scene(speaker, person, units)
    base = portrait(camera, speaker, scene.mean)
    turned = Pose.from_vectors([0.0, np.radians(turn), 0.0], np.zeros(3)).rotation
    window = Window(0, 0, *size, SAMPLES)
    candidate = Candidates.one(np.zeros(0), Pose(base.rotation @ turned, base.translation))
    drawn = renderer.draw(scene, candidate, camera, window)[0]
    if palette == "classes":
        large = CLASS_COLOURS[drawn.class_id]
    else:
        large = np.where(drawn.covered[..., None], drawn.image, np.array(BACKGROUND, np.uint8))
    return np.asarray(cv2.resize(large, size, interpolation=cv2.INTER_AREA), np.uint8)


def _scene(speaker: Speaker, person: str, units: Mapping[str, float]) -> Scene:
    """The person's head in the posture, without modes."""
    unknown = [name for name in units if name not in speaker.unit_names]
    if unknown:
        raise ParameterError(
            f"there is no face unit '{unknown[0]}'", f"choose of {', '.join(speaker.unit_names)}"
        )
    vertices = speaker.named(person)
    if units:
        deltas = speaker.unit_matrix(tuple(units))
        vertices = vertices + np.tensordot(np.array(list(units.values()), np.float32), deltas, 1)
    none = np.zeros((0, *vertices.shape), np.float32)
    return Scene(
        vertices,
        none,
        speaker.faces,
        speaker.uv,
        speaker.facet_class.astype(np.int32),
        speaker.texture(person),
    )
