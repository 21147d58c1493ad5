"""The public names are there, and importing the package costs nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import abs_engine


def test_every_public_name_can_be_imported():
    for name in abs_engine.__all__:
        assert getattr(abs_engine, name).__doc__
    assert dir(abs_engine) == sorted(abs_engine.__all__)
    assert set(abs_engine._HOME) == set(abs_engine.__all__)
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = abs_engine.no_such_name


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, abs_engine; print({'numpy', 'moderngl', 'cv2'} & set(sys.modules))"
    folders = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=folders
    )
    assert done.stdout.strip() == "set()"
