"""Live Link Face's packets: ARKit's 52 weights and the head's angles, by UDP."""

from __future__ import annotations

import socket
import struct
import time
from typing import Any
from uuid import NAMESPACE_DNS, uuid5

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import OutputError
from abs_engine.core.pose import parted
from abs_engine.export.face_units import UnitFit
from abs_engine.export.live_link import EYES, ORDER, angles_of
from abs_engine.io.assets import load_speaker
from abs_engine.live.release import Released
from abs_engine.tracking.options import ClipTracker, Tell

Destination = tuple[int, Any]
NAME = "abs_engine"
_VERSION = 6
_DAY = 86400


def packet(name: str, seconds: float, rate: float, values: NDArray[np.float64] | None) -> bytes:
    """A packet of version 6, as PyLiveLinkFace 0.1 reads it.

    Parameters
    ----------
    seconds : float
        Time of day of the frame.
    rate : float
        Frames per second.
    values : (61,) float64 or None
        Weights, then angles in radians; None where no face is seen.
    """
    identity, coded, fps = uuid5(NAMESPACE_DNS, name), name.encode(), max(1, round(rate))
    whole, part = divmod(round(seconds * fps, 6), 1)  # as 32 bits have it, never 1
    head = struct.pack("<I", _VERSION) + f"${identity}".upper().encode()
    head += struct.pack("!i", len(coded)) + coded
    if values is None:
        return head + struct.pack("!IfII", int(whole), part, fps, 1)
    return head + struct.pack("!IfIIB61f", int(whole), part, fps, 1, len(values), *values)


def reached(address: str) -> Destination:
    """Destination of packets for HOST:PORT, by IPv4 where it has an address there.

    Raises
    ------
    OutputError
        If there is no such host.
    """
    host, _, port = address.rpartition(":")
    try:
        found = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", "it is not a name")
        raise OutputError(f"there is no host {host} ({why})", "give an IP") from error
    kind, *_, at = min(found, key=lambda one: one[0] != socket.AF_INET)  # as who listens does
    return kind, at


class LiveLink:
    """Sends results to a program that listens for Live Link Face; a context manager.

    Parameters
    ----------
    destination : tuple
        As `reached` gives it.
    tell : callable
        Called once, with why, if packets cannot be sent.
    """

    def __init__(self, destination: Destination, tracker: ClipTracker, tell: Tell) -> None:
        kind, self._address = destination
        speaker = load_speaker()
        self._order = [speaker.unit_names.index(name) for name in ORDER]
        self._fit = UnitFit.of(speaker, tracker.setting.face.body)
        self._rate = tracker.setting.rate
        self._socket = socket.socket(kind, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self._socket.setblocking(False)
        self._tell: Tell | None = tell

    def send(self, released: Released) -> None:
        """Send a result; nobody need listen."""
        values, result = None, released.result
        if result.found and result.pose is not None:
            weights = self._fit.weights(parted(result.vector)[1])[self._order]
            values = np.r_[weights, angles_of(result.pose), np.zeros(len(EYES))]
        now = time.time() - released.delay
        seconds = (now + time.localtime(now).tm_gmtoff) % _DAY
        try:
            self._socket.sendto(packet(NAME, seconds, self._rate, values), self._address)
        except BlockingIOError:
            return  # more at once than the system takes
        except OSError as error:  # a network may be away for a while
            tell, self._tell = self._tell, None
            if tell is not None:
                tell(f"Live Link's packets cannot be sent ({error.strerror})")

    def __enter__(self) -> LiveLink:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()
