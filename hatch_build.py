"""The build's own step: wheel and source archive say which commit they were built from."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CommitHook(BuildHookInterface[Any]):
    """Adds ``abs_engine/_data/commit.json``; without git there is one already, or none."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Write the file and have it packed; an editable install asks git itself."""
        root = Path(self.root)
        if version == "editable" or not (root / ".git").exists():
            return
        try:
            commit = self._git(root, "rev-parse", "HEAD").strip()
            changes = self._git(root, "status", "--porcelain", "--untracked-files=no").strip()
        except (OSError, subprocess.SubprocessError):
            return
        self._folder = tempfile.TemporaryDirectory()
        file = Path(self._folder.name) / "commit.json"
        text = json.dumps({"commit": commit, "dirty": bool(changes)}) + "\n"
        file.write_text(text, encoding="utf-8")
        build_data["force_include"][str(file)] = "abs_engine/_data/commit.json"

    @staticmethod
    def _git(root: Path, *words: str) -> str:
        command = ["git", "-C", str(root), *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
