"""Mouth curves of clips by MediaPipe's face mesh, for `people_agreement.py --curves`.

Run it by hand with a Python that has `mediapipe` and `av`, which need not be the project's:
`python tests/detector_curves.py OUT.json CLIPS`. For each frame `aperture` is how far the inner
lips' middles are apart and `width` how far the inner corners are, both over the distance of the
outer eye corners; null where no face is found.
"""

import json
import sys
from pathlib import Path

import av
import mediapipe
import numpy as np

MIDDLES, CORNERS, EYES = (13, 14), (78, 308), (33, 263)


def curves(clip: Path) -> dict[str, list[float | None]]:
    """Aperture and width of each frame of a clip."""
    found: dict[str, list[float | None]] = {"aperture": [], "width": []}
    with (
        mediapipe.solutions.face_mesh.FaceMesh(refine_landmarks=True) as mesh,
        av.open(str(clip)) as container,
    ):
        aspect = float(container.streams.video[0].sample_aspect_ratio or 1)
        for frame in container.decode(video=0):
            square = frame.reformat(width=round(frame.width * aspect), format="rgb24")
            picture = np.rot90(square.to_ndarray(), round(frame.rotation / 90) % 4)
            faces = mesh.process(np.ascontiguousarray(picture)).multi_face_landmarks
            for name, pair in (("aperture", MIDDLES), ("width", CORNERS)):
                found[name].append(_share(faces[0].landmark, pair, picture) if faces else None)
    return found


def _share(points, pair, picture) -> float:
    """Distance of a pair of points over that of the eyes' outer corners."""
    height, width = picture.shape[:2]
    apart = [
        np.hypot((points[a].x - points[b].x) * width, (points[a].y - points[b].y) * height)
        for a, b in (pair, EYES)
    ]
    return float(apart[0] / apart[1])


if __name__ == "__main__":
    made = {Path(clip).stem: curves(Path(clip)) for clip in sys.argv[2:]}
    about = f"MediaPipe face mesh {mediapipe.__version__}"
    Path(sys.argv[1]).write_text(json.dumps({"about": about, "clips": made}), encoding="utf-8")
