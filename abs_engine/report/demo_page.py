"""The demo's report as one HTML page beside its pictures."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

from abs_engine.report.reproduction import cautioned

_STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222 }
img, video { max-width: 100%; display: block }
table { border-collapse: collapse } td { border-bottom: 1px solid #ddd; padding: 2px 1.5em 2px 0 }
td:first-child { white-space: pre } .key span { padding: 0 .5em; margin-right: .5em }
"""
_KEY = (
    ("outer contour", "rgb(60,255,120)"),
    ("upper inner contour", "rgb(255,230,0)"),
    ("lower inner contour", "rgb(80,190,255)"),
)


def head_given(person: str, person_known: bool) -> str:
    """Which head the tracker was given, and what that means for the numbers."""
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
    """Why lip points are worse in camera coordinates than in head coordinates.

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
) -> str:
    """The page; it shows the video and the files of ``run`` and ``evaluation`` beside it.

    Parameters
    ----------
    person : str
        Who was filmed.
    video : str
        Address of what was filmed, from the page.
    run : dict
        What ``run.json`` holds.
    rows : sequence of (str, str)
        What was measured, and its number.
    remarks : sequence of str
        What was given to the tracker, and what to know about the numbers.
    """
    summary = run["summary"]
    key = "".join(f'<span style="background:{colour}">{name}</span>' for name, colour in _KEY)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>abs_engine demo</title>
<style>{_STYLE}</style></head><body>
{cautioned(run)}<h1>Lips tracked by rendering</h1>
<p>The studio filmed {html.escape(person)} with a renderer of its own, with noise and compression
(<a href="{html.escape(video)}">{html.escape(video)}</a>). The tracker was given that video,
the camera's calibration and a head, nothing else of the truth, with which its results are compared
here.</p>
<p>{html.escape(remarks[0])}</p>
<h2>Tracked against truth</h2>
{_table(rows)}
{"".join(f"<p>{html.escape(remark)}</p>" for remark in remarks[1:])}
<p>{summary["frames"]} frames, {summary["mean_evaluations"]:.0f} drawings compared and
{summary["seconds_per_frame"]:.3f} s a frame after {summary["preparation_seconds"]:.1f} s of
preparation, drawn by {html.escape(str(run["renderer"]))}.</p>
<img src="evaluation/truth_curves.png" alt="aperture, width and lip error over time">
<h2>The video with the lips drawn on it</h2>
<p class="key">{key}</p>
<video src="run/overlay.mp4" controls loop></video>
<p>If the browser does not play it: <a href="run/overlay.mp4">run/overlay.mp4</a>.</p>
<h2>The mouth, frame by frame</h2>
<img src="run/contact_sheet.png" alt="enlarged mouths with contours">
<p>Numbers: <a href="run/results.csv">run/results.csv</a>,
<a href="evaluation/truth_scores.json">evaluation/truth_scores.json</a>.</p>
</body></html>
"""


def _table(rows: Sequence[tuple[str, str]]) -> str:
    cells = (f"<tr><td>{html.escape(a)}</td><td>{html.escape(b)}</td></tr>" for a, b in rows)
    return f"<table>{''.join(cells)}</table>"
