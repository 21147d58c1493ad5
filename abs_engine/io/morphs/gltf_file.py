"""glTF files: what their JSON says, and the bytes that it names, which stay in their folder."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

import pygltflib as gl

from abs_engine.core.errors import InputFileError
from abs_engine.io.inputs import check_file, parse_json

_GLB, _JSON, _BIN = b"glTF", b"JSON", b"BIN\0"
_HEAD, _CHUNK = 12, 8
"""Bytes before the chunks of a GLB, and before the content of each."""
DRACO = "KHR_draco_mesh_compression"
_UNREAD = (DRACO, "EXT_meshopt_compression")
_READ = re.compile(r"KHR_(texture_transform|mesh_quantization|lights_punctual|materials_\w+)")
"""Extensions that are read, or change nothing that a head is made of."""
_PICTURES = re.compile(r"(KHR|EXT|MSFT)_texture_\w+")
"""Extensions of pictures, which are refused where a material that is drawn has one."""


@dataclass(frozen=True)
class GltfFile:
    """A document, and the bytes that go with it.

    Parameters
    ----------
    document : pygltflib.GLTF2
    binary : bytes
        The file's own bytes, of a GLB.
    """

    path: Path
    document: gl.GLTF2
    binary: bytes
    _known: dict[str, bytes] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path) -> GltfFile:
        """Read a GLB or glTF file.

        Raises
        ------
        ValueError, TypeError, OSError
            If it is damaged.
        InputFileError
            If it is not there, too large, compressed, or needs an extension that is not known.
        """
        check_file(path)
        content = path.read_bytes()
        is_glb = path.suffix.lower() == ".glb"
        text, binary = _chunks(content) if is_glb else (content, b"")
        told = parse_json(text.decode("utf-8"))
        if not isinstance(told, dict):
            raise ValueError("no document")
        for name in map(str, told.get("extensionsRequired") or ()):
            if name in _UNREAD:
                raise InputFileError(f"{path} is compressed by {name}", "export it without")
            if not _READ.fullmatch(name) and not _PICTURES.fullmatch(name):
                raise InputFileError(f"{path} needs {name}, which is not read", "export it without")
        _drop_notes(told)
        document = gl.GLTF2.from_json(json.dumps(told), infer_missing=True)
        return cls(path, document, binary)

    def bytes_at(self, uri: str | None) -> bytes:
        """Bytes that the document names: its own, or those of a file beside it or below.

        Raises
        ------
        ValueError, InputFileError
            If there is no such file, or it lies elsewhere.
        """
        if uri is None:
            return self.binary
        if uri not in self._known:
            self._known[uri] = _of_data(uri) if uri.startswith("data:") else self._beside(uri)
        return self._known[uri]

    def _beside(self, uri: str) -> bytes:
        folder = self.path.parent.resolve()
        place = (folder / unquote_to_bytes(uri).decode("utf-8")).resolve()
        if "://" in uri or not place.is_relative_to(folder):
            raise InputFileError(
                f"{self.path} names '{uri}'", "files that it names must lie beside it, or below"
            )
        check_file(place, f"put it there, as {self.path.name} names it")
        return place.read_bytes()


def _drop_notes(document: dict[str, Any]) -> None:
    """Drop `extras` that are no table: glTF allows any JSON, pygltflib does not."""
    listed = [one for kind in document.values() if isinstance(kind, list) for one in kind]
    parts = [part for one in listed if isinstance(one, dict) for part in one.get("primitives", ())]
    for holder in (document, document.get("asset"), *listed, *parts):
        if isinstance(holder, dict) and not isinstance(holder.get("extras"), dict):
            holder.pop("extras", None)


def _of_data(uri: str) -> bytes:
    head, _, body = uri.partition(",")
    if not head.endswith(";base64"):
        raise ValueError("data that are not in base64")
    return base64.b64decode(body)


def _chunks(content: bytes) -> tuple[bytes, bytes]:
    """JSON and bytes of a GLB; chunks of other kinds are left out."""
    found, at, end = dict[bytes, bytes](), _HEAD, int.from_bytes(content[8:_HEAD], "little")
    if content[:4] != _GLB or end > len(content):
        raise ValueError("no GLB, or cut off")
    while at < end:
        size = int.from_bytes(content[at : at + 4], "little")
        kind, at = content[at + 4 : at + _CHUNK], at + _CHUNK
        if at + size > end:
            raise ValueError("a chunk reaches beyond the end")
        found.setdefault(kind, content[at : at + size])
        at += size
    return found[_JSON], found.get(_BIN, b"")
