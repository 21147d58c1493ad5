"""A folder for compiled loops, where numba would find none that it may write to.

numba keeps what it compiles beside the source or in the user's cache, and fails where it may write
to neither, as in a container whose user owns no file.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

_VARIABLE = "NUMBA_CACHE_DIR"


def find_cache() -> None:
    """Have numba use a temporary folder of the user's own, if there is no usual one to write to.

    Without that either, numba complains where it compiles.
    """
    package = Path(__file__).parent
    # not Path.expanduser, which fails for a user without a home
    cache = Path(os.path.expanduser(os.environ.get("XDG_CACHE_HOME") or "~/.cache"))
    given = os.environ.get(_VARIABLE)
    usual = [package / "__pycache__", cache / "numba", *([Path(given)] if given else [])]
    if any(_writable(folder) for folder in usual):
        return
    try:
        os.environ[_VARIABLE] = _temporary()
    except OSError:
        return
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = os.environ[_VARIABLE]


def _writable(folder: Path) -> bool:
    """Whether a folder may be written to, or made."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def _temporary() -> str:
    """A temporary folder that nobody else may write to, one for all of a user's processes."""
    import tempfile  # hardly ever needed

    folder = Path(tempfile.gettempdir()) / f"abs_engine-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if folder.is_symlink() or found.st_uid != os.getuid() or found.st_mode & 0o077:
            raise PermissionError
    except OSError:  # somebody else's: what lies there may not be trusted
        return tempfile.mkdtemp(prefix="abs_engine-")
    return str(folder)
