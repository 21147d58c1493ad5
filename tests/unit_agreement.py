"""Weights of face units, of a recording that is known and of runs, from two faces at weight 0.

Run it by hand. `python tests/unit_agreement.py recorded` takes 300 frames of the Live Link Face
recording, makes of each the posture of the tracker that comes nearest, and says how far the weights
found of it are from those recorded. `python tests/unit_agreement.py RUN [RUN...]` says of runs how
jaw and lips are in closed and in open frames, what the units lose, and how far another head, ICT's,
opens its lips with the weights. Each is done from the neutral face, and from the mean of the
tracker's mouth without a cost of weights, as versions before did.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from runs import toy_model

from abs_engine.core.arrays import FloatArray
from abs_engine.export.exporter import TrackedRun, read_run, rms
from abs_engine.export.face_units import UnitFit
from abs_engine.export.settings import EXPORT
from abs_engine.face.held_head import held_head
from abs_engine.face.neutral import neutral_face
from abs_engine.face.schema import ICT_68, reading
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.io.assets import CLOSED_APERTURE, load_speaker
from abs_engine.io.morphs import read_morphs
from abs_engine.studio.speech.livelink import read_livelink

RECORDING = Path("livelink_rom") / "alex_rom_3.csv"
FRAMES, LIP_SHARE = 300, 5.0
COSTS = (1e-6, 0.14, 0.3, 0.55)
SHOWN = ("jawOpen", "mouthClose", "mouthRollLower", "mouthRollUpper")


def from_mean(fit: UnitFit) -> UnitFit:
    """The same, of units on the mean."""
    return replace(fit, mean=np.zeros_like(fit.mean))


def recorded() -> list[str]:
    """Lines on weights that are known."""
    speaker = load_speaker()
    body = held_head(toy_model(), np.zeros(toy_model().n_person)).body
    take = read_livelink(Path(os.environ["ABS_ENGINE_DATA"]) / RECORDING)
    picked = np.random.default_rng(0).choice(len(take.weights), FRAMES, replace=False)
    moved = [name in mouth_units() for name in speaker.unit_names]  # others the tracker has not
    weights = take.weights[picked][:, [take.unit_names.index(n) for n in speaker.unit_names]]
    weights = weights * moved
    marks, lists = speaker.points["landmark_68"], speaker.points
    neutral = neutral_face(body, marks)
    share = np.zeros(len(neutral))
    share[lists["face"]] = 1.0
    share[lists["lips"]] = LIP_SHARE
    share = np.sqrt(np.repeat(share, 3))
    units = speaker.units.astype(np.float64)
    made = (np.tensordot(weights, units, 1) + neutral - body.mean).reshape(FRAMES, -1) * share
    modes = (body.modes.reshape(len(body.modes), -1) * share).T.astype(np.float64)
    postures = made @ np.linalg.pinv(modes).T
    plain = UnitFit.of(speaker, body, COSTS[0])
    fits = {"from the mean": (from_mean(plain), body.mean)}
    fits |= {f"cost {c:g} mm": (UnitFit.of(speaker, body, c), neutral) for c in COSTS}
    lines = []
    for name, (fit, base) in fits.items():
        found = np.array([fit.weights(one) for one in postures])
        off = (found - weights)[:, moved]
        lips = lists["lips"]
        face = np.tensordot(found, units[:, lips], 1) + base[lips]
        true = np.tensordot(postures, body.modes[:, lips], 1) + body.mean[lips]
        bias = " ".join(
            f"{n} {(found - weights)[:, speaker.unit_names.index(n)].mean():+.3f}" for n in SHOWN
        )
        lines.append(
            f"{name:15s} weights {np.sqrt((off**2).mean()):.3f} RMS, lips {rms(face - true):.2f} mm"
            f"; mean error: {bias}"
        )
    return lines


def of_run(run: TrackedRun) -> list[str]:
    """Lines on a run."""
    aperture = run.arrays["aperture"][run.frames]
    jaw = run.arrays["jaw_opening"][run.frames]
    closed, wide = aperture < CLOSED_APERTURE, aperture > np.quantile(aperture, 0.8)
    lines = [f"{run.folder.name}: {len(aperture)} frames, {closed.sum()} closed"]
    lines[0] += f"; jaw opening closed {jaw[closed].mean():.1f} mm, open {jaw[wide].mean():.1f} mm"
    fit = UnitFit.of(run.speaker, run.mesh)
    before = from_mean(UnitFit.of(run.speaker, run.mesh, COSTS[0]))
    for name, one, base in (("mean", before, run.mesh.mean), ("neutral", fit, run.neutral)):
        weights = np.array([one.weights(run.mesh.weights[k]) for k in run.frames])
        opened = weights[:, run.speaker.unit_names.index("jawOpen")]
        apart, along = (np.corrcoef(opened, other)[0, 1] for other in (aperture, jaw))
        lost = " ".join(
            f"{area} {_lost(run, weights, base, area):.2f}" for area in ("lips", "face")
        )
        lines.append(
            f"  {name:8s} r of jawOpen with aperture {apart:.2f}, jaw {along:.3f}; loses {lost} mm"
        )
        other = weights @ ict_slopes(run.speaker.unit_names)
        off = np.maximum(other, 0) - aperture
        lines.append(
            f"           ICT's lips closed {other[closed].mean():+.1f} mm, open "
            f"{other[wide].mean():.1f} mm (tracked {aperture[wide].mean():.1f} mm); off by "
            f"{rms(off):.2f} mm, r {np.corrcoef(other, aperture)[0, 1]:.3f}"
        )
        for state, chosen in (("closed", closed), ("open", wide)):
            means = weights[chosen].mean(axis=0)
            shown = (f"{n} {means[run.speaker.unit_names.index(n)]:.2f}" for n in SHOWN)
            lines.append(f"           {state:6s} {'  '.join(shown)}")
    return lines


def ict_slopes(names: tuple[str, ...]) -> FloatArray:
    """How far each unit opens the middles of the inner lips of ICT's head, (U,) mm at weight 1."""
    mesh = read_morphs(Path(os.environ["ABS_ENGINE_DATA"]) / "ict")
    upper, lower = ICT_68[62], ICT_68[66]
    opened = dict.fromkeys(names, 0.0)
    for target, moved in mesh.targets.items():
        if (unit := reading(target)[0]) in opened:
            opened[unit] += 10.0 * float(moved[upper, 1] - moved[lower, 1])
    return np.array(list(opened.values()))


def _lost(run: TrackedRun, weights: FloatArray, base: FloatArray, area: str) -> float:
    index = run.speaker.points[area]
    made = np.tensordot(weights, run.speaker.units[:, index].astype(np.float64), 1) + base[index]
    return rms(made - run.mesh.points(index)[run.frames])


if __name__ == "__main__":
    asked = sys.argv[1:]
    if not asked:
        sys.exit(__doc__)
    sys.stdout.write(f"cost of a weight: {EXPORT.weight_cost:g} mm\n")
    for word in asked:
        told = recorded() if word == "recorded" else of_run(read_run(Path(word)))
        sys.stdout.write("\n".join(told) + "\n")
