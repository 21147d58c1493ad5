"""Settings of the import of heads: what is taken for a face, and how its parts are made."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HeadImportSettings:
    """Settings of the import of heads: what is taken for a face, and how its parts are made.

    Attributes
    ----------
    face_like : float, correlation
        Of a face's landmarks with a usual one's at least. Chosen: ICT's people have 0.98.
    small : float, share of a usual face
        Below which landmarks are of none in the largest unit. Not measured.
    off_mesh : float, share of the mesh's greatest extent
        That a landmark given by its place lies from the nearest vertex at most. Not measured.
    oblique : float, degrees
        From right angles, up to which a head is left as it is. Chosen: ICT's people nod by 4, in
        the median.
    beside : float, mm
        That eyes may lie beside their usual place. Chosen: those of ICT's people lie by up to 10.
    most_fixed : float, mm
        That a face unit moves the eyes' corners or the nose by at most. Chosen: ICT's do by up to
        3.
    most_apart : float, mm
        That a landmark of another person's face lies from the head's at most. Chosen: of 1000
        people of ICT's components, those of the farthest do so by 23.
    alike : float, correlation
        Of displacements with the head itself, above which they are places. Not measured.
    rescaled : float, ratio
        Of sizes of a face and the head, from which on it is in another unit. Chosen: of mm, cm,
        inches and m, the nearest are 2.5 and the next 10 times each other.
    ring_aside : float, mouth widths
        That a ring of the lips may begin away from its right end. Not measured.
    ring_below : float, mouth widths
        That its upper half may lie lower, as lips overlap. Not measured.
    chin_below : float, mm
        By which a chin lies lower than the lips, and the nose higher, at least. Chosen: on ICT's
        people by 10 and more.
    lid : float, share of the greatest motion
        By which closing eyes move more of what is a lid, and not painted as a brow. Chosen by
        drawings of the bundled head's mesh, which moves by half as much under its brows: with 0.5
        brows come down with the lids, with 0.15 they are torn; the network sees it as before.
    still : float, share of a target's greatest motion
        By which it leaves a vertex where it is. Not measured.
    aside : float, share of its motion
        By which a unit lies, or moves, to a side at least. Not measured.
    same : float, share of it
        By which two targets that mean the same may differ. Not measured.
    part_near : float, mm
        From the tip of the nose, within which eyes, teeth and tongue begin. Chosen: they do by 80.
    least_opening : float, mm
        By which `jawOpen` at weight 1 has to open the lips. Chosen: that of ARKit's heads does so
        by 30.
    ajar : float, weight of `jawOpen`
        At which lips lie apart. Not measured.
    moved : float, share of the jaw's motion
        By more than which what moves goes with the lower jaw. Not measured.
    sunk : float, mm
        Behind its place, where the inside of a mouth is put, so that nothing pokes through other
        lips. Not measured.
    hollow : float, mm
        From the lips: so deep is the inside of a mouth at least. Not measured.
    most_jaw : float, times the bundled jaw's motion
        That the lower part of it moves by at most. Not measured.
    forehead : float, mm
        Above the eyes, where the face ends that is scored. Not measured.
    behind_eyes : float, mm
        Behind their outer corners, where it ends, too. Not measured.
    under_chin : float, mm
        Below the chin, where it ends, too. Not measured.
    spacing : tuple of float, mm
        Between its points, those of the lips and those of the jaw: as in the bundled head. Not
        measured.
    jaw_share : float, share of the jaw's greatest motion
        From which on skin is scored as the jaw's. Not measured.
    """

    face_like: float = 0.9
    small: float = 0.2
    off_mesh: float = 0.05
    oblique: float = 5.0
    beside: float = 20.0
    most_fixed: float = 20.0
    most_apart: float = 50.0
    alike: float = 0.9
    rescaled: float = 5.0
    ring_aside: float = 0.15
    ring_below: float = 0.05
    chin_below: float = 5.0
    lid: float = 0.3
    still: float = 1e-3
    aside: float = 0.3
    same: float = 0.02
    part_near: float = 150.0
    least_opening: float = 4.0
    ajar: float = 0.5
    moved: float = 0.4
    sunk: float = 1.5
    hollow: float = 20.0
    most_jaw: float = 3.0
    forehead: float = 30.0
    behind_eyes: float = 25.0
    under_chin: float = 5.0
    spacing: tuple[float, ...] = (4.0, 1.5, 3.0)
    jaw_share: float = 0.5


HEAD_IMPORT = HeadImportSettings()
