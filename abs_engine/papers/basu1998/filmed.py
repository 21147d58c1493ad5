"""Talking heads filmed for the experiments: no dots, known truth, seen from -45 to 45 degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.dataset import load_dataset
from abs_engine.dataset.view import Truth
from abs_engine.face.appearance.chroma import matched
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.labelled import train_classes
from abs_engine.face.head import COLOUR_CLASSES
from abs_engine.io.naming import made_before
from abs_engine.studio.filming import film_scene
from abs_engine.studio.make import Crew
from abs_engine.studio.scenefile import parse_scene

SIZE = (640, 480)
YAWS = (-45, -22, 0, 22, 45)  # degrees from which the head is seen
FILMED, KINDS, FRONTS = "filmed", ("still", "moving"), "fronts"
RATES = {"still": 12.5, "moving": 25.0, FRONTS: 12.5}
"""Frames per second: few where each is fitted by itself, the usual where a head is followed."""
SAID = "_ w i: m eI b eI k S O: t p U d I N z _ f O: j u: v @ r aI @ n @ b aU t dZ u: n _"
"""What is said in the test, in X-SAMPA; other words than those that are learned from."""
SAID_FOR_COLOURS = "_ dZ Q n w U d h { v p r f 3: d m O: b r aI t tS i: z _"
FRONT = "yaw0"
_NEXT = np.ones((3, 3), np.uint8)
_RADIUS = 560.0  # mm from the head to the cameras
_KEYS = (
    "{ time = 0.0 }, { time = 1.0, turn_degrees = [4, -32, 0] }, "
    "{ time = 2.4, turn_degrees = [-4, 32, 4] }, { time = 3.6, turn_degrees = [2, -10, -3] }"
)


@dataclass(frozen=True)
class Amount:
    """Amount of film.

    Parameters
    ----------
    people : tuple of str
        Of the speaker.
    test, colours, moving : int
        Frames for each camera: fitted with the pose known, learned colours from, and of a head
        that turns.
    recorded : int
        Frames of each person on whom lips of the recording are tested; 0 leaves that out.
    """

    people: tuple[str, ...]
    test: int
    colours: int
    moving: int
    recorded: int = 0


QUICK = Amount(("clara",), 8, 12, 20)
FULL = Amount(("clara", "ravi", "kofi"), 50, 20, 75, recorded=50)


def camera_name(yaw: int) -> str:
    """Name of the camera that sees the head from `yaw` degrees."""
    return f"yaw{yaw}".replace("-", "_")


def scene_of(amount: Amount, seed: int, kind: str) -> str:
    """The scene file of the heads that keep still, of those that move, or of `FRONTS`."""
    head = [
        'format = "abs_engine.scene"', "version = 1", f"seed = {seed}", f"rate = {RATES[kind]}",
        f"size = [{SIZE[0]}, {SIZE[1]}]", "labels = []",
    ]  # fmt: skip
    lamps = [
        '[[light]]\nname = "key"\ndirection = [0.5, -0.5, -1]\nintensity = 3.0',
        '[[light]]\nname = "fill"\ndirection = [-0.9, -0.1, -0.75]\nintensity = 1.2',
    ]
    names = [camera_name(yaw) for yaw in YAWS]
    sides = [names[0], FRONT, names[-1]]
    clips = []
    for person in amount.people:
        if kind == "moving":
            motion = f"{{ keys = [{_KEYS}] }}"
            clips.append(_clip(person, "moving", SAID, amount.moving, [FRONT], motion))
            continue
        few = "{ amount = 0.3 }"
        clips.append(_clip(person, "colours", SAID_FOR_COLOURS, amount.colours, sides, few))
        tests = [FRONT] if kind == FRONTS else names
        clips.append(_clip(person, "test", SAID, amount.test, tests, few))
    return "\n\n".join(["\n".join(head), *map(_camera, YAWS), *lamps, *clips]) + "\n"


def _camera(yaw: int) -> str:
    x, z = _RADIUS * math.sin(math.radians(yaw)), 60 + _RADIUS * math.cos(math.radians(yaw))
    return (
        f'[[camera]]\nname = "{camera_name(yaw)}"\n'
        f"position = [{x:.1f}, -30, {z:.1f}]\ntarget = [0, -15, 60]"
    )


def _clip(
    person: str, kind: str, said: str, frames: int, cameras: Iterable[str], motion: str
) -> str:
    seen = ", ".join(f'"{c}"' for c in cameras)
    return (
        f'[[clip]]\nname = "{person}-{kind}"\nspeaker = "{person}"\nsay = "{said}"\n'
        f"frames = {frames}\ncameras = [{seen}]\nmotion = {motion}"
    )


def film(
    amount: Amount, folder: Path, seed: int, kinds: Iterable[str] = KINDS
) -> dict[tuple[str, str, str], Truth]:
    """Film what the experiments need, or what an interrupted run left to be filmed.

    Parameters
    ----------
    folder : Path
        Made if need be.
    kinds : iterable of str
        Of `RATES`.

    Returns
    -------
    dict
        Views by person, kind of clip and camera.
    """
    folder.mkdir(parents=True, exist_ok=True)
    views = {}
    for kind in kinds:
        scene, crew = parse_scene(scene_of(amount, seed, kind)), Crew(keep=True)
        if not made_before(folder / kind):
            film_scene(scene, folder / kind, command="abs-engine reproduce 000", crew=crew)
        for view in load_dataset(folder / kind):
            person, what = view.folder.parent.name.rsplit("-", 1)
            views[person, what, view.folder.name] = view
    return views


def learn_colours(views: Sequence[Truth]) -> ColourClasses:
    """Colour classes from labelled pixels near the mouth, of every fourth frame of some views."""
    none: NDArray[np.generic] = np.zeros((0, 3), np.float32)
    pixels = {name: [none] for name in CLASSES}
    for view in views:
        for frame, picture in enumerate(view.pictures()):
            if frame % 4 == 0:
                for name, found in _labelled(view, frame, matched(picture)).items():
                    pixels[name].append(found)
    return train_classes({name: np.concatenate(found) for name, found in pixels.items()})


def _labelled(
    view: Truth, frame: int, picture: NDArray[np.generic]
) -> dict[str, NDArray[np.generic]]:
    """Pixels (N, 3) of each class near the lips; those on the border of skin and lips left out.

    Their neighbours have a little of their chroma. Those beside the opening stay: there the lips
    lie in their own shade, and would else be taken for the dark of the mouth.
    """
    shown = view.class_ids(frame)
    where = {
        name: np.isin(shown, [view.class_names.index(c) for c in of if c in view.class_names])
        for name, of in COLOUR_CLASSES.items()
    }
    columns = np.flatnonzero(where["lips"].any(axis=0))
    if len(columns) == 0:
        return {}
    reach = max(3, int(0.6 * (columns[-1] - columns[0])))
    near = cv2.dilate(where["lips"].astype(np.uint8), np.ones((reach, reach), np.uint8)) > 0
    skin = cv2.dilate(where["skin"].astype(np.uint8), _NEXT) > 0
    clear = {"skin": cv2.erode(where["skin"].astype(np.uint8), _NEXT) > 0}
    clear["lips"] = where["lips"] & ~skin
    return {name: picture[clear.get(name, mask) & near] for name, mask in where.items()}
