"""The table of pictures of visemes: poses given and left out, and lines that are wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from abs_engine.capture.viseme_pictures import read_viseme_pictures
from abs_engine.core.errors import AbsEngineError

VISEMES = ("a", "ipi")
POSES = "picture,viseme,rx,ry,rz,tx,ty,tz\n"


def _written(folder: Path, text: str) -> Path:
    (folder / "a.png").write_bytes(b"")
    path = folder / "pictures.csv"
    path.write_text(text)
    return path


def test_poses_are_given_or_left_to_be_estimated(tmp_path):
    text = POSES + "a.png,a,3.1,0,0.1,1,2,640\na.png,ipi,,,,,,\n"
    first, second = read_viseme_pictures(_written(tmp_path, text), VISEMES)
    assert (first.viseme, second.viseme) == VISEMES
    assert first.path == tmp_path / "a.png"
    np.testing.assert_allclose(first.pose.rotation_vector, [3.1, 0, 0.1], atol=1e-9)
    assert first.pose.translation.tolist() == [1, 2, 640]
    assert second.pose is None


def test_without_columns_of_poses_all_are_estimated(tmp_path):
    (only,) = read_viseme_pictures(_written(tmp_path, "picture,viseme\na.png,a\n"), VISEMES)
    assert only.pose is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("picture,viseme\na.png,epe\n", "line 2: there is no viseme 'epe'"),
        ("picture,viseme\nb.png,a\n", "line 2: there is no picture 'b.png'"),
        ("picture,viseme\n", "give a line of column names"),
        ("picture,sound\na.png,a\n", "lacks the columns viseme"),
        ("picture,viseme,rx\na.png,a,1\n", "lacks the columns ry"),
        (POSES + "a.png,a,1,2,3,4,,6\n", "line 2: a part of the pose is missing"),
        (POSES + "a.png,a,1,2,3,4,x,6\n", "'x' in column ty is not a number"),
        (POSES + "a.png,a,-175,1,2,3,4,5\n", "line 2: the head is turned by 175 radians, more"),
    ],
)
def test_lines_that_are_wrong_are_named(tmp_path, text, said):
    with pytest.raises(AbsEngineError, match=said):
        read_viseme_pictures(_written(tmp_path, text), VISEMES)
