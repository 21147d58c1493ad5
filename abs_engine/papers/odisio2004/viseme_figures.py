"""Figures 4, 5 and 6: nomograms of texture, points of local appearance, residuals of visemes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer
from abs_engine.face.talking import TalkingFace
from abs_engine.papers.odisio2004.visemes import ASKED, NEUTRAL, PRINTED, Speech, VisemeError
from abs_engine.report.drawing.layout import beside, captioned, stacked
from abs_engine.report.drawing.lines import draw_circles

DEVIATIONS = (-2.0, 0.0, 2.0)
_NAMED = 3  # the worst visemes of a group that are named, as in the paper
_HALF_MM = 0.5
_MARK = (60, 220, 90)


def residual_figure(errors: Mapping[str, Sequence[VisemeError]]) -> Figure:
    """Figure 6: a box for each model, of the residuals of the test visemes, by a panel's title."""
    asked = [n for n in (*ASKED, NEUTRAL) if any(e.model == n for f in errors.values() for e in f)]
    labels = [f"{PRINTED[n]}\nas printed" if n in PRINTED else n for n in asked]
    figure = Figure(figsize=(6.0 * len(errors), 3.6), layout="constrained")
    for axes, (title, found) in zip(
        figure.subplots(1, len(errors), squeeze=False, sharey=True)[0], errors.items(), strict=True
    ):
        groups = [[e for e in found if e.model == name] for name in asked]
        axes.boxplot(
            [[e.rms for e in group] for group in groups],
            tick_labels=labels, widths=0.5, medianprops={"color": "black"},
            flierprops={"marker": "+", "markersize": 4},
        )  # fmt: skip
        for place, group in enumerate(groups, 1):
            worst = sorted(group, key=lambda e: -e.rms)[:_NAMED]
            for row, e in enumerate(worst):
                axes.annotate(
                    e.viseme, (place + 0.27, e.rms), (0, 5 - 7 * row), textcoords="offset points",
                    fontsize=6, color="0.35",
                )  # fmt: skip
        axes.axhline(_HALF_MM, color="0.8", lw=0.8, zorder=0)
        axes.set_yscale("log")
        axes.margins(y=0.1)  # room for the highest name, and for the last
        axes.set_xlim(0.5, len(asked) + 0.75)
        axes.set_yticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
        axes.minorticks_off()
        axes.set(title=title, ylabel="residual of a viseme, RMS (mm)")
    return figure


def texture_nomograms(face: TalkingFace, camera: Camera, pose: Pose, renderer: Renderer) -> Image:
    """Figure 4: textures of one parameter at a time, all on the same, unmoved shape."""
    scene, names = face.shape.surface, face.shape.model.parameters
    still = Candidates.one(np.zeros(0), pose)
    window = camera.whole
    lines = []
    for name in ("jaw1", "lips1"):
        tiles = []
        for value, texture in zip(
            DEVIATIONS, face.tex_lin.nomogram(names.index(name), DEVIATIONS), strict=True
        ):
            plain = type(scene)(
                scene.mean, scene.modes[:0], scene.faces, scene.uv, scene.facet_class, texture
            )
            drawn = renderer.draw(plain, still, camera, window)[0]
            rgb = np.where(drawn.covered[..., None], drawn.rgb, 255).astype(np.uint8)
            tiles.append(captioned(_cropped(rgb, drawn.covered), f"{name} {value:+g} sd"))
        lines.append(beside(tiles))
    return stacked(lines)


def _cropped(rgb: NDArray[np.uint8], covered: NDArray[np.bool_]) -> Image:
    rows, columns = (np.flatnonzero(covered.any(axis=a)) for a in (1, 0))
    cut = rgb[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    factor = max(1, round(260 / cut.shape[0]))
    return np.asarray(cv2.resize(cut, None, fx=factor, fy=factor), np.uint8)


def points_figure(speech: Speech, face: TalkingFace, which: Sequence[int]) -> Image:
    """Figures 5 and 9: where local appearance is compared, on pictures of the corpus."""
    tiles = []
    seen = speech.pictures
    for k in which:
        vertices = face.shape.outer.vertices(speech.built.alpha[k])[face.la_lin.vertices]
        flat = seen.camera.project(seen.poses[k].apply(vertices))
        factor = max(1, round(640 / seen.camera.size[0]))
        picture = cv2.resize(seen.pictures[k], None, fx=factor, fy=factor)
        draw_circles(picture, factor * (flat + 0.5) - 0.5, 4, _MARK, 1)
        tiles.append(captioned(np.asarray(picture, np.uint8), f"/{seen.visemes[k]}/"))
    return beside(tiles)
