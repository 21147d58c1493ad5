"""Meshes with morph targets, as files of other programs hold them."""

from __future__ import annotations

from abs_engine.io.morphs.mesh import MorphMesh
from abs_engine.io.morphs.read import read_morphs

__all__ = ["MorphMesh", "read_morphs"]
