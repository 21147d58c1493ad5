"""Fixtures for all tests: the process's OpenGL context, a watch over GL errors, large data."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

# Before NumPy is loaded: a second thread for each worker's small matrices only waits in a loop for
# a core that another worker has, at several times the cost.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from abs_engine.core.errors import OpenGLError
from abs_engine.dataset import Truth, load_truth
from abs_engine.render.context import GLContext
from abs_engine.render.raster import OpenGLRenderer

TESTS = Path(__file__).parent
FIRST = (
    "report/test_demo.py",
    "studio/test_studio_scene.py",
    "report/test_report_browser.py",
    "package/test_docs.py",
    "package/test_leaves.py",
    "package/test_packaging.py",
    "tracking/speaker/test_speaker.py",
    "fit/test_track_fit.py",
    "studio/test_speech_articulation.py",
    "clips/test_many_clips.py",
    "live/test_live_session.py",
    "evaluate/test_check.py",
    "tracking/test_track_api.py",
)
"""The files that take longest, in the order in which they are begun.

The tests of a file are run by one process, and one that began with such a file at the end would
still be at it while the others wait. The first three compile little that is the same, so that what
one compiles is there for the others later on; the wheel's tests take it from there, too.
"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes longest begins first; the rest keeps its order."""
    place = {TESTS / name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


def missing(what: str) -> None:
    """Skip, but under CI=true fail: there nothing that can exist may be left out."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what} is needed under CI=true")
    pytest.skip(what)


@pytest.fixture(scope="session")
def gl() -> Iterator[GLContext]:
    """The OpenGL context of this test process."""
    try:
        context = GLContext.open()
    except OpenGLError as error:
        missing(str(error))
        raise
    with context:
        yield context


@pytest.fixture(params=["thin", "instanced"])
def renderer(gl: GLContext, request: pytest.FixtureRequest) -> Iterator[OpenGLRenderer]:
    """An OpenGL renderer, by either vertex path."""
    with OpenGLRenderer(gl, request.param) as opened:
        yield opened


@pytest.fixture(autouse=True)
def no_gl_error() -> Iterator[None]:
    """A GL error belongs to the test that made it."""
    yield
    context = GLContext.of_process()
    if context is not None:
        with context.current():
            assert context.ctx.error == "GL_NO_ERROR"


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of recordings that are not shipped: ABS_ENGINE_DATA, or beside the checkout."""
    beside = Path(__file__).parents[2] / "shared" / "data"
    folder = Path(os.environ.get("ABS_ENGINE_DATA") or beside)
    if not folder.is_dir():
        pytest.skip("the recordings are missing; ABS_ENGINE_DATA names their folder")
    return folder


@pytest.fixture(scope="session")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    """Half a second of clara, filmed by the studio for whichever process needs it first."""
    from abs_engine.report.demo import film_clip  # and Matplotlib with it, which few tests need

    kept, apart = tmp_path_factory.getbasetemp(), "PYTEST_XDIST_WORKER" in os.environ
    shared = (kept.parent if apart else kept) / "filmed"
    if not shared.exists():
        own = tmp_path_factory.mktemp("film") / "clip"
        film_clip(own, "demo", person="clara", size=(320, 240), frames=14)
        try:
            own.rename(shared)
        except OSError:  # another process was at it, too, and was done first
            return load_truth(own)
    return load_truth(shared)


@pytest.fixture(scope="module")
def soon_ready() -> Iterator[None]:
    """Clips are made ready in the shortest time, where not what is learned of them is tested."""
    from hurried import hurried  # and the tracker with it, which few tests need

    with hurried(frames=2, rounds=1):
        yield
