"""The choice of a dataset's clip and camera for a report, a score or a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from abs_engine.core.errors import ParameterError
from abs_engine.dataset import Truth, codec, load_truth
from abs_engine.dataset.dataset import Dataset, choices, dataset_root, read_record
from abs_engine.dataset.sums import read_sums
from abs_engine.evaluate.same_clip import video_sum


def shown_view(
    path: Path, clip: str | None, camera: str | None, results: Sequence[Path] = ()
) -> tuple[Truth, tuple[str, ...]]:
    """The view that is asked for; if several fit, that whose very video was tracked.

    With it come the others of the dataset, as CLIP/CAMERA.

    Parameters
    ----------
    path : Path
        A dataset, DATASET/CLIP or DATASET/CLIP/CAMERA.
    clip, camera : str, optional
        Names that the path leaves open.
    results : sequence of Path
        What is reported. A run may hold the checksum of its video.

    Raises
    ------
    InputFileError
        If there is no dataset.
    ParameterError
        If no view or several fit, or the results are of different views.
    """
    root, given = dataset_root(path)
    dataset = read_record(root)
    fitting = _fitting(dataset, given, clip, camera)
    sums = read_sums(root)
    videos = {view: sums.get("/".join((*view, codec.VIDEO))) for view in dataset.views}
    views = {checksum: view for view, checksum in videos.items()}
    tracked = {path: views.get(digest) for path in results if (digest := video_sum(path))}
    known = [view for view in tracked.values() if view is not None]
    _check_one(tracked)
    if known and known[0] not in fitting:
        raise ParameterError(
            f"the runs are of {'/'.join(known[0])}, not of {choices(fitting)}",
            f"give --clip {known[0][0]} --camera {known[0][1]}",
        )
    fitting = known[:1] or fitting
    if len(fitting) > 1:
        other = next(iter(tracked), None) if all(videos.values()) else None
        no = "" if other is None else f" none of the video of {other},"
        raise ParameterError(
            f"{path} holds {len(fitting)} views,{no} and one is needed: {choices(fitting)}",
            "choose with --clip and --camera" if other is None else "give the truth of that video",
        )
    truth = load_truth(root / fitting[0][0] / fitting[0][1])
    others = tuple("/".join(view) for view in dataset.views if view != fitting[0])
    return truth, others


def found_truth(
    path: Path, clip: str | None = None, camera: str | None = None, results: Sequence[Path] = ()
) -> Truth:
    """The truth of the view that is asked for; if several fit, of that which was tracked.

    Parameters as of `shown_view`. Whether the results are of the one view that fits is left to
    `same_clip.check_clip`.

    Raises
    ------
    InputFileError
        If there is no dataset.
    ParameterError
        If no view or several fit.
    """
    root, given = dataset_root(path)
    fitting = _fitting(read_record(root), given, clip, camera)
    if len(fitting) == 1:
        return load_truth(root / fitting[0][0] / fitting[0][1])
    return shown_view(path, clip, camera, results)[0]


def _fitting(
    dataset: Dataset, given: tuple[str, ...], clip: str | None, camera: str | None
) -> list[tuple[str, str]]:
    """Views that go with the path and with the names."""
    begun = [view for view in dataset.views if view[: len(given)] == given]
    found = [v for v in begun if clip in (None, v[0]) and camera in (None, v[1])]
    if not found:
        asked = "/".join((*given, *(name for name in (clip, camera) if name)))
        raise ParameterError(
            f"{dataset.folder} has no view '{asked}'", f"there are {choices(dataset.views)}"
        )
    return found


def _check_one(tracked: dict[Path, tuple[str, str] | None]) -> None:
    """Refuse runs of different views."""
    if len({view for view in tracked.values() if view is not None}) > 1:
        told = ", ".join(f"{p.name} of {'/'.join(v)}" for p, v in tracked.items() if v is not None)
        raise ParameterError(
            f"a report shows one clip by one camera, but the runs are of several ({told})",
            "write one report for each",
        )
