"""MediaPipe's face mesh over a clip, run by a Python that has it; it imports nothing of ours.

`python peer_worker.py VIDEO` writes a line of JSON.
"""

from __future__ import annotations

import json
import sys


def main() -> int:
    """Look at every frame, as it does where nothing is chosen; say how many, and which version."""
    import cv2
    import mediapipe

    video, seen, frames = cv2.VideoCapture(sys.argv[1]), 0, 0
    with mediapipe.solutions.face_mesh.FaceMesh() as mesh:
        while True:
            there, image = video.read()
            if not there:
                break
            found = mesh.process(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))
            frames, seen = frames + 1, seen + bool(found.multi_face_landmarks)
    told = {"frames": frames, "seen": seen, "version": mediapipe.__version__}
    sys.stdout.write(json.dumps(told) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
