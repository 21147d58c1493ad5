"""A film of followed dots, for a person who checks them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.io.files import write_new

if TYPE_CHECKING:
    from abs_engine.capture.session import Moment
    from abs_engine.io.video import VideoWriter


class DotsFilm:
    """A film of the dots, whole or not at all; nothing where no path is given."""

    def __init__(self, path: Path | None, rate: float) -> None:
        self._path, self._rate = path, rate
        self._folder = tempfile.TemporaryDirectory()
        self._writer: VideoWriter | None = None

    def add(self, moment: Moment) -> None:
        """Append a frame."""
        if self._path is None:
            return
        from abs_engine.capture.overlay import draw_views
        from abs_engine.io.video import VideoWriter

        picture = draw_views(moment.images, moment.sightings, moment.names)
        if self._writer is None:
            size = picture.shape[1], picture.shape[0]
            self._writer = VideoWriter(self._file, size, self._rate)
        self._writer.write(picture)

    def finish(self) -> None:
        """Close the film and put it in its place."""
        if self._path is not None and self._writer is not None:
            self._writer.close()
            self._writer = None
            write_new(self._path, self._file.read_bytes())

    @property
    def _file(self) -> Path:
        return Path(self._folder.name) / "overlay.mp4"

    def __enter__(self) -> DotsFilm:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()
        self._folder.cleanup()
