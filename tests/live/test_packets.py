"""Live Link Face's packets, taken apart as PyLiveLinkFace 0.1.0 does (`PyLiveLinkFace.decode`)."""

from __future__ import annotations

import errno
import os
import socket
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from runs import toy_result, toy_setting, written_run

from abs_engine.core.errors import OutputError
from abs_engine.export.exporter import read_run
from abs_engine.export.face_units import unit_weights
from abs_engine.export.live_link import EYES, HEAD, ORDER, live_link_rows
from abs_engine.io.assets import load_speaker
from abs_engine.live.packets import LiveLink, packet, reached
from abs_engine.live.release import Released

VALUES = np.linspace(0, 1, 61)


def decoded(data):
    """The fields as that library reads them, by its own offsets."""
    (version,) = struct.unpack("<i", data[0:4])
    identity = data[4:41].decode("utf-8")
    (length,) = struct.unpack("!i", data[41:45])
    end = 45 + length
    name = data[45:end].decode("utf-8")
    if len(data) <= end + 16:
        return version, identity, name, None
    frame, part, fps, denominator, count = struct.unpack("!if2ib", data[end : end + 17])
    return (
        version,
        identity,
        name,
        (frame, part, fps, denominator, count, struct.unpack("!61f", data[end + 17 :])),
    )


def test_a_packet_is_read_back():
    version, identity, name, face = decoded(packet("Jo", 3600.5, 30.0, VALUES))
    assert (version, name) == (6, "Jo")
    assert identity.startswith("$")
    assert len(identity) == 37
    frame, part, fps, denominator, count, values = face
    assert (frame, fps, denominator, count) == (108015, 30, 1, 61)
    assert part == pytest.approx(0.0)
    np.testing.assert_allclose(values, VALUES, atol=1e-6)


def test_a_frame_s_part_never_rounds_up_to_the_next():
    """29 / 25 * 25 is a little less than 29, and less than that by too little for 32 bits."""
    fps = 25
    assert 29 / fps * fps < 29
    frame, part, *_ = decoded(packet("Jo", 29 / fps, fps, VALUES))[3]
    assert (frame, part) == (29, 0)
    frame, part, *_ = decoded(packet("Jo", 29.25 / fps, fps, VALUES))[3]
    assert (frame, part) == (29, 0.25)


def test_a_frame_without_a_face_has_no_values():
    assert decoded(packet("Jo", 1.0, 25.0, None))[3] is None


def test_every_unit_has_its_place():
    assert sorted(ORDER) == sorted(load_speaker().unit_names)
    assert len(ORDER) + len(HEAD) + len(EYES) == 61
    assert (ORDER[0], ORDER[17], ORDER[51]) == ("eyeBlinkLeft", "jawOpen", "tongueOut")


def test_what_is_sent_are_the_weights_that_an_export_has(tmp_path):
    folder = written_run(tmp_path / "run", (0, 3))
    exported = live_link_rows(read_run(folder))
    run = read_run(folder)
    places = [run.speaker.unit_names.index(name) for name in ORDER]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there:
        there.bind(("127.0.0.1", 0))
        there.settimeout(5)
        to = reached(f"127.0.0.1:{there.getsockname()[1]}")
        with LiveLink(to, SimpleNamespace(setting=toy_setting()), pytest.fail) as link:
            for frame, posture in enumerate((0, 3)):
                link.send(Released(None, toy_result(frame, posture), 0.1, 0))
                sent = decoded(there.recv(1000))[3][-1]
                weights = unit_weights(run)[frame, places]
                np.testing.assert_allclose(sent[:52], weights, atol=1e-5)
                np.testing.assert_allclose(sent[52:], exported[frame, 52:], atol=1e-5)
    assert max(unit_weights(run)[0]) < 0.1  # the face at rest


@pytest.mark.parametrize("host", ["a..b", "a" * 64, "\udcff"])
def test_what_is_no_name_of_a_host_is_refused(host):
    with pytest.raises(OutputError, match="it is not a name"):
        reached(f"{host}:11111")


def test_a_host_with_addresses_of_both_kinds_is_reached_by_ipv4(monkeypatch):
    both = [(socket.AF_INET6, 2, 17, "", ("::1", 1, 0, 0)), (socket.AF_INET, 2, 17, "", ("::", 1))]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: both)
    assert reached("localhost:1") == (socket.AF_INET, ("::", 1))
    del both[1]
    assert reached("[::1]:1") == (socket.AF_INET6, ("::1", 1, 0, 0))


def test_packets_can_be_broadcast_and_the_first_that_cannot_be_sent_is_named():
    said, tracker = [], SimpleNamespace(setting=toy_setting())
    with LiveLink(reached("255.255.255.255:9"), tracker, said.append) as link:
        assert link._socket.getsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST)
        link._socket = Unreachable(link._socket)
        for index in range(3):
            link.send(Released(None, toy_result(index), 0.1, 0))
    assert said == ["Live Link's packets cannot be sent (Network is unreachable)"]


class Unreachable:
    """A socket whose network is away."""

    def __init__(self, found):
        self.close = found.close

    def sendto(self, *_):
        raise OSError(errno.ENETUNREACH, os.strerror(errno.ENETUNREACH))
