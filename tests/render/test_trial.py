"""A plugin's renderer is tried on a triangle before it is used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import abs_engine
from abs_engine.cli import main
from abs_engine.core.errors import OpenGLError, PluginError
from abs_engine.core.registry import RENDERERS
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.select import open_renderer, opened_renderer


class Own:
    """The CPU rasteriser, whose drawings are changed."""

    description = "own"
    closed = 0

    def __init__(self) -> None:
        self._own = CpuRenderer()

    def draw(self, *given):
        return self.change(self._own.draw(*given))

    def close(self):
        type(self).closed += 1
        self._own.close()

    __enter__, __exit__ = (lambda self: self), (lambda self, *_: self.close())


def half(drawn):
    return [replace(one, **{n: a[::2, ::2] for n, a in vars(one).items()}) for one in drawn]


FAULTS = [
    (lambda drawn: None, "draws an object of type NoneType, not a list"),
    (lambda drawn: [], "draws 0 of 2 candidates"),
    (lambda drawn: [one.rgb for one in drawn], "draws an object of type ndarray, not Buffers"),
    (half, "draws rgb of shape (15, 23, 3), not (30, 45, 3)"),
    (
        lambda drawn: [replace(one, depth=None) for one in drawn],
        "draws an object of type NoneType for depth",
    ),
    (
        lambda drawn: [replace(one, facet_id=one.facet_id / 1.0) for one in drawn],
        "draws facet_id as float64",
    ),
    (
        lambda drawn: [replace(one, depth=one.depth * np.nan) for one in drawn],
        "draws depth that is not finite",
    ),
    (
        lambda drawn: [replace(one, facet_id=one.facet_id * 0) for one in drawn],
        "draws nothing of a triangle that fills the window",
    ),
    (
        lambda drawn: [replace(one, class_id=(one.facet_id > 0).astype(int)) for one in drawn],
        "draws class_id of another class than the triangle's",
    ),
    (lambda drawn: 1 / 0, "fails (ZeroDivisionError: division by zero) in test_trial.py, line "),
]


@pytest.fixture
def opened(request):
    """Opens a class of renderers by name."""

    def by_name(kind):
        RENDERERS.add("mine", kind)
        request.addfinalizer(lambda: RENDERERS._added.pop("mine", None))
        return open_renderer("mine")

    return by_name


@pytest.mark.parametrize(("change", "said"), FAULTS)
def test_a_renderer_that_draws_wrongly_is_named_and_closed(change, said, opened):
    kind = type("Changed", (Own,), {"change": staticmethod(change)})
    with pytest.raises(PluginError) as caught:
        opened(kind)
    assert f"the renderer 'mine' {said}" in str(caught.value)
    assert kind.closed == 1


def test_a_renderer_that_draws_as_the_engine_s_is_taken(opened):
    kind = type("Same", (Own,), {"change": staticmethod(lambda drawn: drawn)})
    with opened(kind) as renderer:
        assert renderer.description == "own"
    assert kind.closed == 1


def test_a_renderer_that_cannot_be_made_or_closed_is_named(opened):
    with pytest.raises(PluginError, match="'mine' cannot be used in a 'with' statement"):
        opened(type("Bare", (), {"description": "x", "draw": print, "close": print}))
    missing = {"__enter__": print, "__exit__": print, "draw": print, "close": lambda self: None}
    with pytest.raises(PluginError, match="'mine' has no 'description'"):
        opened(type("Nameless", (), missing))
    with pytest.raises(PluginError, match=r"'mine' fails \(ZeroDivisionError"):
        opened(lambda: 1 / 0)


class Shut(CpuRenderer):
    def close(self):
        raise OSError("no such device")


class Lost(CpuRenderer):
    def close(self):
        raise OpenGLError("the context is gone", "start again")


def test_a_renderer_that_cannot_be_closed_is_warned_of(monkeypatch, tmp_path, caplog):
    monkeypatch.setitem(RENDERERS._added, "mine", Shut)
    picture = tmp_path / "head.png"
    assert main(["render", "portrait", "-o", str(picture), "--renderer", "mine"]) == 0
    assert picture.is_file()
    (line,) = caplog.messages
    assert line.startswith("closing the renderer 'mine' fails (OSError: no such device) in test_tr")


class Once(Own):
    def draw(self, *given):
        if self.drew:
            raise KeyError("gone")
        self.drew = True
        return self._own.draw(*given)

    drew = False


def test_a_renderer_that_fails_after_its_trial_is_named(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(RENDERERS._added, "mine", Once)
    picture = tmp_path / "head.png"
    assert main(["render", "portrait", "-o", str(picture), "--renderer", "mine"]) == 2
    assert "the renderer 'mine' fails (KeyError: 'gone') in test_trial.py, line" in (
        capsys.readouterr().err
    )


class Measured(CpuRenderer):
    def measure(self, *given):
        raise KeyError("gone")


def test_each_method_of_a_renderer_is_named_and_its_class_known(monkeypatch):
    monkeypatch.setitem(RENDERERS._added, "mine", Measured)
    with opened_renderer("mine") as drawn:
        assert isinstance(drawn, CpuRenderer)
        with pytest.raises(PluginError, match=r"'mine' fails \(KeyError: 'gone'\) in test_trial"):
            drawn.measure()


def test_an_error_of_the_engine_in_closing_is_warned_of_too(monkeypatch, caplog):
    monkeypatch.setitem(RENDERERS._added, "mine", Lost)
    with opened_renderer("mine"):
        pass
    assert caplog.messages == ["the context is gone; start again"]


def test_a_failure_counts_more_than_that_of_closing(monkeypatch, caplog):
    monkeypatch.setitem(RENDERERS._added, "mine", Shut)
    with pytest.raises(ZeroDivisionError), opened_renderer("mine"):
        raise ZeroDivisionError
    assert "closing the renderer 'mine' fails" in caplog.text


def test_an_open_renderer_is_tried_too(tmp_path):
    from runs import write_noise

    kind = type("Empty", (Own,), {"change": staticmethod(lambda drawn: [])})
    with pytest.raises(PluginError, match="the renderer 'Empty' draws 0 of 2"):
        abs_engine.track(write_noise(tmp_path / "noise.mp4"), renderer=kind())
