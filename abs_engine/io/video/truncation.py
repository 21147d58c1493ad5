"""The test for a truncated video: a file that ends within a unit whose length it states.

Each container has its own units. What cannot be judged counts as whole, for a false alarm would
keep a good video out; decoder and header are asked too, see `abs_engine.io.video.ending`.

Sources: RFC 8794 (EBML), ISO/IEC 14496-12 (boxes), ISO/IEC 13818-1 (program and transport stream),
"Multimedia Programming Interface and Data Specifications 1.0" (RIFF, AVI's container).
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

_EBML, _SEGMENT = b"\x1a\x45\xdf\xa3", b"\x18\x53\x80\x67"
_PACK, _END = b"\x00\x00\x01\xba", 0xB9
_TS_SYNC, _TS_PACKET = 0x47, 188
_TAIL = 1 << 18  # bytes from the end in which a pack of a program stream is looked for


def is_torn(path: Path) -> bool:
    """Whether the file stops short of what it says of itself.

    False also where the container is none of Matroska, MP4 and its kin, AVI, MPEG program stream,
    MPEG transport stream.
    """
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(4096)
        if head.startswith(_EBML):
            return _segment_end(head) > size
        if head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"):
            return _boxes_end(file, size) > size
        if head.startswith(b"RIFF"):
            return 8 + int.from_bytes(head[4:8], "little") > size
        if head.startswith(_PACK):
            file.seek(max(0, size - _TAIL))
            return _packs_torn(file.read())
        if _is_transport(head):
            return size % _TS_PACKET != 0
    return False


def _segment_end(head: bytes) -> int:
    """End of Matroska's one segment; 0 where its length is not stated (a live recording)."""
    length, start = _ebml_length(head, 4)
    at = start + length
    if head[at : at + 4] != _SEGMENT:
        return 0
    length, start = _ebml_length(head, at + 4)
    return start + length if length >= 0 else 0


def _ebml_length(data: bytes, at: int) -> tuple[int, int]:
    """A variable-length size, -1 where it is unknown, and where the content starts."""
    if at >= len(data) or data[at] == 0:
        return -1, at
    octets = 9 - data[at].bit_length()
    value = int.from_bytes(data[at : at + octets]) & ((1 << 7 * octets) - 1)
    return -1 if value == (1 << 7 * octets) - 1 else value, at + octets


def _boxes_end(file: BinaryIO, size: int) -> int:
    """End of the last top-level box; `size` where the boxes make no sense."""
    at = 0
    while at + 8 <= size:
        file.seek(at)
        head = file.read(16)
        length, smallest = int.from_bytes(head[:4]), 8
        if length == 1:
            length, smallest = int.from_bytes(head[8:]), 16
        if length == 0:  # to the end of the file
            return size
        if length < smallest or not head[4:8].isascii():
            return size
        at += length
    return at


def _packs_torn(tail: bytes) -> bool:
    """Walk the units of a program stream from the first pack on."""
    at = tail.find(_PACK)
    while 0 <= at < len(tail):
        unit = tail[at : at + 14]
        if len(unit) >= 4 and (unit[:3] != b"\x00\x00\x01" or unit[3] < _END):
            return False  # out of step, as in padding after the last pack
        if len(unit) < 6:
            return unit.strip(b"\x00") != b"" and unit[3:4] != bytes([_END])
        if unit[3] == _END:
            at += 4
        elif unit[3] == _PACK[3]:
            at += 12 if unit[4] >> 4 == 2 else 14 + (unit[-1] & 7)  # MPEG-1, MPEG-2
        else:
            at += 6 + int.from_bytes(unit[4:6])
    return at > len(tail)


def _is_transport(head: bytes) -> bool:
    marks = head[::_TS_PACKET][:8]
    return len(marks) > 1 and all(mark == _TS_SYNC for mark in marks)
