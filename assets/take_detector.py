"""Take the face detector and the landmark and iris networks out of MediaPipe's wheel.

Their licence comes with them. The landmark network is cut in two, see `cut_landmarks.py`.

Usage: ``python assets/take_detector.py WHEEL [OUTPUT_FOLDER]``
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import zipfile
from pathlib import Path

from cut_landmarks import parts

FETCH = "pip download mediapipe==0.10.14 --no-deps --python-version 3.11 --only-binary :all:"
NETWORK = "mediapipe/modules/face_detection/face_detection_short_range.tflite"
LANDMARKS = "mediapipe/modules/face_landmark/face_landmark_with_attention.tflite"
IRIS = "mediapipe/modules/iris_landmark/iris_landmark.tflite"
LICENCE = "mediapipe-0.10.14.dist-info/LICENSE"
SHA256 = {  # the wheels of all platforms hold these same files
    NETWORK: "bbff11cebd1eb27a1e004cae0b0e63ec8c551cbf34a4451148b4908b8db3eca8",
    LANDMARKS: "e06a804e0144f9929eda782122916b35d60c697c3c9344013ca2bbe76a6ce2b4",
    IRIS: "d1744d2a09c25f501d39eba4faff47e53ecca8852c5ce19bce8eeac39357521f",
    LICENCE: "8707eef0533987efc5b155d64761eeb6e20793f50b9bd1a68dad1cf4719d0ed8",
}
NAMES = {
    NETWORK: Path(NETWORK).name,
    IRIS: Path(IRIS).name,
    LICENCE: "LICENSE.txt",
}


def members(wheel: Path) -> dict[str, bytes]:
    """The files of `SHA256` in a wheel, by their names there.

    Raises
    ------
    ValueError
        If it is not the wheel that they were taken from.
    """
    try:
        with zipfile.ZipFile(wheel) as opened:
            found = {name: opened.read(name) for name in SHA256}
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise ValueError(f"{wheel} does not hold the networks") from error
    for name, content in found.items():
        if hashlib.sha256(content).hexdigest() != SHA256[name]:
            raise ValueError(f"{name} of {wheel} is not the file that was taken")
    return found


def main() -> int:
    """Write the files; 2 if the wheel is missing or another one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", nargs="?", type=Path, help="mediapipe-0.10.14-...whl")
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "detector"
    )
    options = parser.parse_args()
    try:
        found = members(options.wheel or Path("the wheel"))
    except ValueError as error:
        sys.stderr.write(f"{error}; fetch it with:  {FETCH}\n")
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    files = {NAMES[name]: content for name, content in found.items() if name in NAMES}
    for name, content in (files | parts(found[LANDMARKS])).items():
        (options.output / name).write_bytes(content)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
