"""The dataset card: the ``README.md`` that tells people what a dataset holds."""

from __future__ import annotations

from typing import Any

from abs_engine.core.provenance import described
from abs_engine.dataset.codec import CHUNK, CLOSED_BELOW, COVER_NAMES, DEPTH_STEP, LABELS, UNUSED

_LABEL_TEXT = {
    "ids": "16 bit, index of the facet + 1; 0 where the head is not seen, or is covered",
    "depth": f"16 bit, steps of {DEPTH_STEP} mm along the optical axis; 0 where ids is 0. In a "
    "mirror: depth of the virtual image behind the glass",
    "normals": "16-bit RGB, smooth unit normal in the camera frame, (n + 1) / 2 * 65534 + 1 of x, "
    "y, z; 0 where ids is 0",
    "albedo": "8-bit RGB, colour of the texture without any light; 0 where ids is 0",
    "flow": "16-bit RGB, (u * 64 + 32768, v * 64 + 32768, valid): where the point of the surface "
    "that is seen here moves to in the next frame, px, by that frame's true geometry, seen there "
    "or not; 0 where not valid and in the last frame (the encoding of KITTI 2015)",
}

_TEXT = """\
# Talking-head dataset

Rendered video of a talking head with exact labels: {frames} frames in {views} views.

| clip | person | what is said | frames | per second | cameras |
|---|---|---|---|---|---|
{clips}

## How it was made

    {command}

with seed {seed} and {engine}. `scene.toml` is the scene as it was filmed: the same
scene, seed and release give the same truth and, before compression, the same pixels. The pictures
were drawn by pyrender, with lights, lens, sensor and compression as the scene says.

## Layout

    dataset.json               for programs: clips, cameras, labels
    timing.json                what a frame cost; it alone differs from one time to the next
    scene.toml                 the scene
    SHA256SUMS                 checksums of the other files, for `sha256sum -c SHA256SUMS`
    CLIP/truth.npz             person, motion, speech; see below
    CLIP/vertices/*.npz        `offsets` (n, V, 3) float16, mm; {chunk} frames to a file, which is
                               named by its first
    CLIP/CAMERA/camera.json    `matrix` and `distortion` (k1, k2, p1, p2, k3, k4, k5, k6) as in
                               OpenCV; `rotations`, `translations` world -> camera, one row for a
                               camera that stands still, else one for each frame; perhaps `mirror`
                               (`rectangle`, four corners in the camera frame)
    CLIP/CAMERA/video.mp4      what the camera saw
    CLIP/CAMERA/frames/*.png   the same before compression, if the scene asked for it
    CLIP/CAMERA/points.npz     the landmarks in pixels, and whether they are seen; see below
    CLIP/CAMERA/coco.json      landmarks and boxes of the head as COCO keypoints; its file names are
                               those of frames/*.png: without these, frame N of video.mp4

Pictures with labels, CLIP/CAMERA/KIND/*.png, one for each frame:

{labels}
- `cover`: 8 bit, what hides the head: {cover}. Only where the scene has something that does.

Frames are counted from 0 in all file names. Every NPZ file names its `format` and `version`.

## Units and frames of reference

Lengths are in millimetres, angles in radians, times in seconds, pixels with centres at integers.
Head frame: x to the subject's left, y up, z out of the face. Camera frame: x right, y down, z
forward, as in OpenCV. Rotations are rotation vectors. The lens distorts vertices and leaves the
edges of the facets, of one to five millimetres, straight. Label pictures have one sample at the
centre of each pixel; the video is multisampled.

`truth.npz`: `rate`, `seed`, `person`, `sentence`, `command`; `unit_weights` (T, 52) of the ARKit
face units `unit_names`; `identity_weights`; `neutral` (V, 3), so that vertices = neutral +
offsets, exactly as filmed; `faces` (F, 3), counter-clockwise from outside; `facet_class` (F,), an
index into `class_names`; `uv` (V, 2), v down; `rotations`, `translations` (T, 3), head -> world;
`phonemes` (T,) and `phoneme_label`, `phoneme_start`, `phoneme_end` (P,); `gap` (T,), the widest
gap between the lips seen from the front, mm, negative where they overlap everywhere; `closed`
(T,), gap below {closed} mm; vertex lists `outer_lip` (a ring), `outer_lip_20` (points 48-59 of the
68), `inner_lip_8` (60-67), `mouth_corners`, `landmark_68` (the order of iBUG 300-W, the subject's
right first); `dots`, the vertices in the middle of beads or ink dots painted on the skin, empty
where there are none.

`points.npz`: `landmark_pixels` (T, 68, 2), `landmark_visible` (T, 68); `lip_pixels` and
`lip_visible`, which are points 48-67; the same with `mirror_` before the name where there is a
mirror; `in_picture` (T,), whether any of the head is seen. What is not before the lens is at -1e6.
A landmark is visible if it is in the picture and neither head nor shirt nor what is held is nearer
to the camera along its ray by more than 1 mm. Those of the lips also count as visible in the seam
of closed lips and in the fold of the mouth's corner: where their own lip is seen within 1.5 mm of
them, across the ray, and nothing is nearer by more than 5 mm. COCO's flag is 2 for visible, 1 for
hidden, 0 outside of the picture.

## Reading and checking

    from abs_engine.dataset import load_dataset
    for truth in load_dataset("."):            # every clip by every camera
        truth.name, truth.camera, truth.rotations  # head -> camera
        for frame in range(len(truth)):
            truth.vertices(frame), truth.facet_ids(frame), truth.depth(frame)

`abs-engine check .` holds all labels against each other and against the checksums.

## Licence

The head is made from MakeHuman's base mesh and shape targets and from the ARKit face units by Mika
Suominen, all CC0 1.0, and its textures are painted by the project's own scripts; pictures of it may
be used without condition.

## Limits

- One head topology; skin without subsurface scattering, no hair on the head, no shadows cast.
- What is said follows a model of coarticulation, not a recording, unless the table says otherwise.
- In p, b and m the lips meet at some time of each interval, not in each frame that is labelled
  with it. One shorter than a frame may have no frame in `phonemes`; they meet in a frame beside it.
- Tongue and teeth are drawn, but the tongue's motion is coarse. In f and v the lower lip goes to
  the upper front teeth: in the middle of each, the median of the gap along them is below 0.25 mm,
  unless a closure beside it needs that frame.
- Labels describe the mesh. Shoulders, background and what covers the head have no facet ids.
"""


def card_text(record: dict[str, Any]) -> str:
    """The card of a dataset, Markdown, by its ``dataset.json``; see `dataset.dataset_record`."""
    clips = record["clips"]
    return _TEXT.format(
        frames=sum(c["frames"] for c in clips),
        views=sum(len(c["cameras"]) for c in clips),
        clips="\n".join(_row(clip) for clip in clips),
        command=record["command"] or "(by a program)",
        seed=record["seed"],
        engine=described({**record, "engine_version": record["engine"]}),
        chunk=CHUNK,
        closed=CLOSED_BELOW,
        labels="\n".join(
            f"- `{kind}`: {_LABEL_TEXT[kind]}" for kind in LABELS if kind in record["labels"]
        ),
        cover=", ".join(f"{n} {text}" for n, text in (*COVER_NAMES.items(), (UNUSED, "not used"))),
    )


def _row(clip: dict[str, Any]) -> str:
    cells = clip["name"], clip["person"], clip["sentence"], clip["frames"], clip["rate"]
    words = [str(cell).replace("|", "\\|") for cell in (*cells, ", ".join(clip["cameras"]))]
    return f"| {' | '.join(words)} |"
