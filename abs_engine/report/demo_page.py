"""The demo's report as one HTML page beside its pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.core.provenance import described
from abs_engine.evaluate.score_table import IN_BRACKETS
from abs_engine.report.document import cautioned, document, safe, table

_STYLE = ".key span { padding: 0 .5em; margin-right: .5em }"
_KEY = (
    ("outer contour", "rgb(60,255,120)"),
    ("upper inner contour", "rgb(255,230,0)"),
    ("lower inner contour", "rgb(80,190,255)"),
)


def head_given(person: str, person_known: bool) -> str:
    """Line about the head that the tracker was given, and its meaning for the numbers."""
    if person_known:
        return (
            f"Head given to the tracker: {person}'s own (speaker-specific tracking); it was not "
            "fitted to the clip."
        )
    return (
        f"Head given to the tracker: the average head, not {person}'s. Where the origin of another "
        "person's head frame lies cannot be observed in a video, so the raw error of the lip "
        "points contains that constant offset; the row with one rigid offset removed does not."
    )


def camera_error(along: float, across: float) -> str:
    """Reason why lip points are worse in camera coordinates than in head coordinates.

    Parameters
    ----------
    along, across : float, mm
        Error of the head's position along and across the line of sight, RMS.
    """
    return (
        "In camera coordinates the error of the head's position is added. Distance is the hard "
        "direction for one camera, which sees it by the head's size only. Head position, RMS: "
        f"{along:.2f} mm along the line of sight, {across:.2f} mm across it."
    )


def demo_page(
    person: str,
    video: str,
    run: dict[str, Any],
    rows: Sequence[tuple[str, str]],
    remarks: Sequence[str],
    sources: Mapping[str, Mapping[str, Any]],
) -> str:
    """The page; it shows the video and the files of ``run`` and ``evaluation`` beside it.

    Parameters
    ----------
    video : str
        Address of what was filmed, from the page.
    sources : mapping of str to mapping
        Provenance of the figures; see `abs_engine.core.provenance.caution`.
    """
    summary = run["summary"]
    key = "".join(f'<span style="background:{colour}">{name}</span>' for name, colour in _KEY)
    body = f"""{cautioned(sources)}<h1>Lips tracked by rendering</h1>
<p>{safe(person)} is one of six drawn people that come with the studio, which filmed this clip with
a renderer of its own and added noise and compression: <a href="{safe(video)}">the video</a>. The
tracker was given this video, the camera's calibration and a head, and nothing else of the truth.
Its results are compared with the truth here.</p>
<p>{safe(remarks[0])}</p>
<h2>Tracked against truth</h2>
{table((), rows)}
<p>{IN_BRACKETS}</p>
{"".join(f"<p>{safe(remark)}</p>" for remark in remarks[1:])}
<p>{summary["frames"]} frames, {summary["mean_evaluations"]:.0f} drawings compared in each,
drawn by {safe(str(run["renderer"]))}; <a href="run/timing.json">what that took</a>. Made by
{safe(described(run))}.</p>
<p><img src="evaluation/truth_curves.png" alt="aperture, width and lip error over time"></p>
<h2>The video with the lips drawn on it</h2>
<p class="key">{key}</p>
<p><video src="run/overlay.mp4" controls loop></video></p>
<p>If the browser does not play it: <a href="run/overlay.mp4">run/overlay.mp4</a>.</p>
<h2>The mouth, frame by frame</h2>
<p><img src="run/contact_sheet.png" alt="enlarged mouths with contours"></p>
<p>Numbers: <a href="run/results.csv">run/results.csv</a>,
<a href="evaluation/scores.json">evaluation/scores.json</a>.</p>"""
    return document("abs_engine demo", body, style=_STYLE)
