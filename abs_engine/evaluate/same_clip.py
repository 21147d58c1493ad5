"""The check that a run is of the very clip, and the very camera, of the truth beside it."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from abs_engine.core.errors import OtherClipError
from abs_engine.dataset import Truth
from abs_engine.dataset.sums import SUMS, read_sums
from abs_engine.tracking.runs.record import run_settings

FOCAL_WARNING = 0.2
"""Share of the true focal length by which a run's may differ without a warning."""

RATE_SHARE = 0.005
"""Share of the true frame rate by which that of the video may differ."""

_REMEDY = "name the view that was tracked with --truth DATASET/CLIP/CAMERA"
_log = logging.getLogger(__name__)


def check_clip(path: Path, run: Mapping[str, NDArray[Any]], truth: Truth) -> None:
    """Refuse a run of another video; warn of another focal length.

    Raises
    ------
    OtherClipError
        If the size of the picture, the frame rate, or the video's checksum is another. A run that
        does not say its video's checksum is taken at its word, with a warning.
    """
    true = truth.camera
    if "camera_size" in run and tuple(run["camera_size"].tolist()) != true.size:
        raise OtherClipError(
            "{} saw pictures of {}x{} pixels, the truth {}x{}".format(
                path, *run["camera_size"].tolist(), *true.size
            ),
            _REMEDY,
        )
    rate = float(run["rate"]) if "rate" in run else truth.rate
    if abs(rate / truth.rate - 1) > RATE_SHARE:
        raise OtherClipError(
            f"{path} has {rate:g} frames a second, the truth {truth.rate:g}", _REMEDY
        )
    _check_video(path, truth)
    focal = float(run["camera_matrix"][0, 0]) if "camera_matrix" in run else true.matrix[0, 0]
    if abs(focal / true.matrix[0, 0] - 1) > FOCAL_WARNING:
        _log.warning(
            "%s was tracked with a focal length of %.0f px, the truth's is %.0f: is it this view?",
            path,
            focal,
            true.matrix[0, 0],
        )


def _check_video(path: Path, truth: Truth) -> None:
    """Hold the checksum of the video that was tracked against the dataset's own."""
    folder = truth.video.resolve().parent
    root = folder.parent.parent
    if not (root / SUMS).is_file():
        return
    listed = read_sums(root)
    wanted = listed.get(truth.video.resolve().relative_to(root).as_posix())
    tracked = video_sum(path)
    if wanted is None or tracked == wanted:
        return
    if tracked is None:
        _log.warning("%s does not say of which video it is; taken to be this clip's", path)
        return
    other = next((name for name, value in listed.items() if value == tracked), None)
    said = "another video than the truth's" if other is None else f"{other} of the same dataset"
    remedy = _REMEDY if other is None else f"give --truth {(root / other).parent}"
    raise OtherClipError(f"{path} is of {said}", remedy)


def video_sum(path: Path) -> str | None:
    """SHA-256 of the video that a run was made from; None where it does not say."""
    known = run_settings(path).get("video_sha256")
    return None if known is None else str(known)
