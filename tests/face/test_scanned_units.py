"""Units of scans on the bundled head's mesh: nothing tears, lips that close just meet."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from abs_engine.core.errors import ModelFormatError
from abs_engine.face.rings import lip_rings
from abs_engine.face.shape import scanned_units
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.face.shape.population import average_person
from abs_engine.face.shape.scanned_units import save_units, unit_differences
from abs_engine.io.assets import load_speaker

SPEAKER, NAMES = load_speaker(), mouth_units()
V = SPEAKER.vertices.astype(np.float64)


def own_and_scanned():
    """The average person's units, and those of scans, (2, N, V, 3)."""
    own = average_person().unit_matrix(NAMES).astype(np.float64)
    return own, own + unit_differences(NAMES)


def from_the_artists(names):
    """Differences from the bundled head's units, whose sides differ a little where they slide."""
    names = tuple(names)
    return (
        unit_differences(names) + average_person().unit_matrix(names) - SPEAKER.unit_matrix(names)
    )


def moved(units, **weights):
    """What units (N, V, 3) do to the head at some weights, (V, 3)."""
    return sum(weight * units[NAMES.index(name)] for name, weight in weights.items())


def gap(shift):
    """By how much the inner lips are apart in the middle, mm, with a displacement (V, 3)."""
    rings, there = lip_rings(SPEAKER), V + shift
    middle = [k[np.abs(V[k, 0]) < 10.0] for k in (rings["upper"], rings["lower"])]
    return there[middle[0], 1].mean() - there[middle[1], 1].mean()


def test_copies_at_seams_of_the_texture_stay_together():
    _, first, of_vertex = np.unique(SPEAKER.weld, return_index=True, return_inverse=True)
    fields = unit_differences(NAMES)
    assert np.abs(fields - fields[:, first[of_vertex]]).max() < 0.01


def test_teeth_and_eyes_move_as_before():
    for name in ("upper_teeth", "lower_teeth", "tongue", "eyes"):
        assert np.abs(unit_differences(NAMES)[:, SPEAKER.vertices_of(name)]).max() < 0.2


def test_units_of_the_two_sides_are_mirror_images():
    other_side = np.array([-1.0, 1.0, 1.0])
    away, across = cKDTree(V).query(V * other_side)
    alike = away < 1e-3
    sides = {"Left": "Right", "Right": "Left"}
    other = {n: n.removesuffix(a) + b for n in NAMES for a, b in sides.items() if n.endswith(a)}
    assert len(other) == 18
    even = [n for n in NAMES if n != "mouthClose"]  # whose size depends on the bundled head's sides
    fields, mirrored = (
        from_the_artists(names) for names in (even, [other.get(n, n) for n in even])
    )
    assert np.abs(fields[:, alike] - mirrored[:, across[alike]] * other_side).max() < 0.01


def test_lips_that_close_over_an_open_jaw_meet_as_at_rest():
    rest = gap(np.zeros_like(V))
    for units in own_and_scanned():
        parted, half = (gap(moved(units, jawOpen=0.5, mouthClose=w)) for w in (0.0, 0.25))
        assert parted > half > rest
        for jaw in (0.2, 0.5):
            assert gap(moved(units, jawOpen=jaw, mouthClose=jaw)) == pytest.approx(rest, abs=0.1)


def test_lips_pucker_and_funnel_farther_forward_than_the_artists():
    ring = lip_rings(SPEAKER)["outer"]
    for name, least in (("mouthPucker", 1.2), ("mouthFunnel", 2.0)):
        artist, scanned = (moved(u, **{name: 1.0})[ring, 2].mean() for u in own_and_scanned())
        assert scanned > least * artist > 0


def test_skin_far_from_the_mouth_hardly_moves_otherwise():
    brows, throat = SPEAKER.points["landmark_68"][17:27], V[:, 1] < -95.0
    fields = unit_differences(NAMES)
    assert np.abs(fields[:, brows]).max() < 0.3
    assert np.sqrt((fields[:, throat] ** 2).sum(axis=2)).max() < 2.0


def test_units_come_in_the_order_that_is_asked_for():
    one, two = unit_differences(NAMES[:2]), unit_differences(NAMES[1::-1])
    np.testing.assert_array_equal(one, two[::-1])


def test_a_unit_that_is_not_there_is_named():
    with pytest.raises(ModelFormatError, match="noseSneerLeft"):
        unit_differences(["jawOpen", "noseSneerLeft"])


def test_a_file_of_another_mesh_is_refused(tmp_path, monkeypatch):
    save_units(tmp_path / "units.npz", NAMES, unit_differences(NAMES)[:, :-1])
    monkeypatch.setattr(scanned_units, "shipped", lambda name: tmp_path / "units.npz")
    with pytest.raises(ModelFormatError, match="make it again with assets/make_units"):
        unit_differences(NAMES)


def test_the_border_of_the_lips_moves_as_scans_do_wherever_it_lies():
    """It does by the bundled head's units, and by the average person's, whose border slid."""
    kept = np.load(scanned_units.shipped(scanned_units.UNITS))
    order = [list(kept["unit_names"]).index(name) for name in NAMES]
    np.testing.assert_allclose(from_the_artists(NAMES), kept["differences"][order], atol=1e-4)
