"""Settings of heads that are followed by their texture: known ones, and from a box or blob."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RegistrationSettings:
    """Settings of heads that are followed by their texture: known ones, and from a box or blob.

    Attributes
    ----------
    least_seen : float, share of a reference's points
        Below which the face counts as lost by it. Not measured.
    seen_well : float, share of them
        Below which another reference is taken. Not measured.
    seen_badly : float, share of them
        Below which the head may be lost before it has turned by `apart`. Not measured.
    apart : float, rad
        Between the ways two references face. Not measured.
    apart_badly : float, rad
        The same where the head is seen badly. Not measured.
    nearer : float, rad
        By which another reference must be nearer to be taken instead. Not measured.
    most_references : int
        That are kept. Not measured.
    references_tried : int
        In one frame. Not measured.
    least_points : int
        That a rigid motion is found from. Not measured.
    least_reference : int, points
        Of a reference that is taken on the way. Not measured.
    most_corners : int, corners
        Of a reference's texture that are followed. Not measured.
    corner_quality : float, share of the best corner's
        Sharpness of a corner that is followed, at least. Not measured.
    corners_across : float, corners
        Across a face, or the shorter side of a drawing, at most. Not measured.
    least_apart : float, pixels
        Between corners at least, however small the face is. Not measured.
    flow_window : int, pixels
        Side of what optical flow compares about a corner. Not measured.
    flow_levels : int, levels
        Of the pyramid in which a reference's corners are followed, above the picture itself. Not
        measured.
    stray : float, median distances
        From where the pose puts it, beyond which a followed corner is not counted as seen. Not
        measured.
    least_stray : float, pixels
        The same at least. Not measured.
    drift : tuple of float, rad and mm
        Standard deviations of a followed head's motion since the last frame. A face is nearly flat
        at its distance, so that depth and tilt are weak; the pull costs little where the corners
        know better. Not measured.
    steps_in_drift : float, first steps
        In each of these. Not measured.
    pose_limit : int, evaluations
        Of a pose by corners or patches, slopes left out. A bound on time: on 25 to 30 frames each
        of four clips at most 12 were needed by corners, and on two of these 25 by patches.
    patch : float, face widths
        Half the side of a patch. Not measured.
    patches_apart : float, face widths
        Between patches at least. Not measured.
    most_patches : int
        Of a face. Not measured.
    patch_quality : float, share of the best patch's
        Sharpness of a patch that is looked for, at least. Not measured.
    least_matches : int
        Without which a head is not aligned. Not measured.
    least_like : float, correlation
        Of a match. Not measured.
    share_drawn : float, share of a patch
        That must be drawn. Not measured.
    best_noise : float, 1 - correlation
        That the best of matches are taken to have. Not measured.
    trust : float, independent pixels
        Of a patch; few, as what is wrong about a drawing is smooth. Not measured.
    small_residual : float, standard deviations
        Beyond which a match counts less. Not measured.
    patch_drift : tuple of float, rad and mm
        Standard deviations of a pose by patches about the last: it is hardly held. Not measured.
    patch_step : tuple of float, rad and mm
        First step of such a pose. Not measured.
    drawn_face : float, drawn pixels across the rigid face
        Where its texture is compared. Not measured.
    fine_face : float, drawn pixels across the rigid face
        Where its details are looked for. Not measured.
    margin : float, sizes of a face
        Around it that are drawn. Not measured.
    least_drawn : float, share of that window
        Covered by the face, with less of which it explains nothing. Not measured.
    smoothing : float, drawn pixels
        Standard deviation of the blur of drawing and picture before details are looked for, against
        noise. Not measured.
    chroma_noise : float, normalised colour
        Standard deviation of a pixel. Not measured.
    observations : float, independent pixels
        Of the face. Not measured.
    alignment_levels : tuple of tuple of float, shares and face widths
        How finely a head is drawn, of `fine_face`, and how far its details are looked for, in
        widths of the face: one step after the other. Not measured.
    settling : int, steps
        By which a followed head settles, at most. Not measured.
    settled : float, mm
        By which the last of these moves it, at most. Not measured.
    astray : float, rad
        That a followed head is off by at most. Not measured.
    levels_tried : int, levels
        From each of several starts; the others from the best only. Not measured.
    nearly : int, level
        From which on a head is aligned whose pose is nearly known. Not measured.
    sure : float, agreement
        Of the head itself at least. Not measured.
    far_pitch : tuple of float, rad
        Starts of a head that is looked for. Not measured.
    far_yaw : tuple of float, rad
        The same. Not measured.
    far_depth : tuple of float, times the guessed distance
        The same. Not measured.
    near_yaw : tuple of float, rad
        Starts about where a head was a moment ago. Not measured.
    near_swing : tuple of float, share of the turn
        The face turns about its own middle, or is swung about the head's. Not measured.
    motions : int
        Of a face whose skull keeps still, that are fitted along. Not measured.
    worse : float, times the texture's error at first
        Beyond which a turned head is not taken for seen. Not measured.
    alike : float, times that error
        An image no worse than that shows the head at any rate. Not measured.
    plain : float, share of an even picture's error
        What explains less may be anything of one colour. Not measured.
    lobes : int
        Of light over half of the sphere. Not measured.
    lobe_width : float, degrees
        Width of a lobe. Chosen by how much a forehead bends behind a brow, which is less: gloss
        cannot draw a brow.
    lobes_turned : float, cosine
        Between a lobe's middle and the line of sight away from the camera, up to which it counts.
        Not measured.
    light_rounds : int
        In which light is found and outliers are left out. Not measured.
    light_outlier : float, median errors
        From which a pixel counts less for the light. Not measured.
    light_noise : float, levels of 255
        That are added to that, for pictures that are explained exactly. Not measured.
    light_pixels : int, pixels
        That the light is found from. A bound on time. Not measured.
    light_ridge : tuple of float, share
        Ridge of what multiplies and of what is added: undetermined terms stay small. Not measured.
    """

    least_seen: float = 0.35
    seen_well: float = 0.7
    seen_badly: float = 0.55
    apart: float = 0.2
    apart_badly: float = 0.1
    nearer: float = 0.1
    most_references: int = 12
    references_tried: int = 2
    least_points: int = 8
    least_reference: int = 16
    most_corners: int = 150
    corner_quality: float = 0.005
    corners_across: float = 40.0
    least_apart: float = 2.0
    flow_window: int = 15
    flow_levels: int = 3
    stray: float = 2.5
    least_stray: float = 1.5
    drift: tuple[float, ...] = (0.15, 0.15, 0.15, 30.0, 30.0, 60.0)
    steps_in_drift: float = 20.0
    pose_limit: int = 30
    patch: float = 0.055
    patches_apart: float = 1 / 30
    most_patches: int = 150
    patch_quality: float = 0.003
    least_matches: int = 12
    least_like: float = 0.5
    share_drawn: float = 0.9
    best_noise: float = 0.02
    trust: float = 0.1
    small_residual: float = 1 / 3
    patch_drift: tuple[float, ...] = (0.5, 0.5, 0.5, 60.0, 60.0, 200.0)
    patch_step: tuple[float, ...] = (0.02, 0.02, 0.02, 2.0, 2.0, 10.0)
    drawn_face: float = 112.0
    fine_face: float = 200.0
    margin: float = 0.3
    least_drawn: float = 0.2
    smoothing: float = 1.0
    chroma_noise: float = 0.01
    observations: float = 500.0
    alignment_levels: tuple[tuple[float, float], ...] = (
        (0.35, 0.20),
        (0.35, 0.12),
        (0.5, 0.08),
        (0.5, 0.06),
        (1.0, 0.04),
        (1.0, 0.03),
    )
    settling: int = 3
    settled: float = 1.5
    astray: float = 0.15
    levels_tried: int = 3
    nearly: int = 2
    sure: float = 0.7
    far_pitch: tuple[float, ...] = (0.0, -0.2, 0.2)
    far_yaw: tuple[float, ...] = (0.0, -0.4, 0.4)
    far_depth: tuple[float, ...] = (1.0, 0.8, 0.65)
    near_yaw: tuple[float, ...] = (-0.45, -0.15, 0.15, 0.45)
    near_swing: tuple[float, ...] = (0.0, 1.0)
    motions: int = 20
    worse: float = 3.0
    alike: float = 1.5
    plain: float = 0.87
    lobes: int = 70
    lobe_width: float = 12.0
    lobes_turned: float = 0.25
    light_rounds: int = 3
    light_outlier: float = 3.0
    light_noise: float = 0.5
    light_pixels: int = 3000
    light_ridge: tuple[float, float] = (1e-4, 3e-3)


REGISTRATION = RegistrationSettings()
