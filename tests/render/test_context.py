"""Opening OpenGL: every backend that exists here, and what is said where one does not."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from conftest import missing

from abs_engine.core.errors import OpenGLError, ParameterError
from abs_engine.render import egl, osmesa
from abs_engine.render.context import BACKENDS, Attempt, GLContext, NoOpenGLError, remedy_of
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer
from abs_engine.render.select import open_renderer

DRAW = """
import sys, numpy as np, shapes
from abs_engine.render.select import open_renderer
scene = shapes.ball(1, 2)
camera, window = shapes.view(32)
with open_renderer(sys.argv[1]) as renderer:
    seen = renderer.draw(scene, shapes.states(scene, 1), camera, window)[0]
    print(int(seen.covered.sum()), renderer.description)
"""


def in_process(code: str, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1]), **variables}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def exists(backend: str) -> bool:
    """Whether the machine has what the backend needs."""
    try:
        if backend == "egl-device":
            return bool(egl.hardware_devices())
        library = "libEGL.so.1" if backend == "egl-surfaceless" else "libOSMesa.so.8"
        ctypes.CDLL(library)
    except (OSError, OpenGLError):
        return False
    return True


@pytest.mark.gl
@pytest.mark.parametrize("backend", BACKENDS)
def test_every_backend_that_exists_draws(backend):
    if not exists(backend):
        if backend == "egl-surfaceless":
            missing("libEGL")
        pytest.skip(f"{backend} cannot exist here")
    done = in_process(DRAW, backend)
    assert done.returncode == 0, done.stderr
    covered, description = done.stdout.split(" ", 1)
    assert 500 < int(covered) < 1000  # the ball fills most of 32x32
    assert description.startswith(backend)
    assert "OpenGL 4." in description


@pytest.mark.gl
def test_a_software_device_is_not_taken_for_a_gpu(gl):
    if gl.hardware:
        pytest.skip("there is a GPU")
    done = in_process(DRAW, "egl-device")
    assert done.returncode == 1
    assert "no EGL device is a GPU" in done.stderr or "draws by software" in done.stderr


@pytest.mark.gl
def test_the_order_is_device_surfaceless_osmesa(gl):
    tried = [a.backend for a in gl.attempts]
    assert tried == list(BACKENDS[: len(tried)])
    assert [a.ok for a in gl.attempts] == [False] * (len(tried) - 1) + [True]


@pytest.mark.gl
def test_a_missing_driver_is_named():
    done = in_process(DRAW, "egl-surfaceless", __EGL_VENDOR_LIBRARY_DIRS="/var/empty")
    assert done.returncode == 1
    assert "apt-get install libgl1-mesa-dri" in done.stderr.splitlines()[-1]


@pytest.fixture
def no_libraries(monkeypatch):
    def refuse(name, *arguments, **options):
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.setattr(ctypes, "CDLL", refuse)


def test_missing_libraries_are_named_with_their_package(no_libraries):
    with pytest.raises(OpenGLError) as caught:
        egl.open_surfaceless()
    assert caught.value.remedy == "apt-get install libegl1 libgl1-mesa-dri"
    with pytest.raises(OpenGLError) as caught:
        osmesa.open_osmesa()
    assert caught.value.remedy == "apt-get install libosmesa6"


def test_the_remedy_is_that_of_the_usual_backend():
    attempts = tuple(Attempt(name, False, "?", f"get {name}") for name in BACKENDS)
    assert remedy_of(attempts) == "get egl-surfaceless"
    assert remedy_of(attempts[:1]) == "get egl-device"


@pytest.mark.parametrize("name", ["gl", *BACKENDS])
def test_hidden_backends_raise(monkeypatch, name):
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    with pytest.raises(NoOpenGLError, match="apt-get install libegl1") as caught:
        open_renderer(name)
    assert all(not a.ok and "hidden" in a.detail for a in caught.value.attempts)


def test_hiding_one_backend_reaches_the_next():
    if not exists("osmesa"):
        pytest.skip("osmesa cannot exist here")
    done = in_process(DRAW, "auto", ABS_ENGINE_HIDE_GL="egl-device,egl-surfaceless")
    assert "osmesa: " in done.stdout, done.stderr


def test_without_opengl_the_cpu_takes_over_with_one_line(monkeypatch, caplog):
    monkeypatch.setenv("ABS_ENGINE_HIDE_GL", "all")
    with open_renderer("auto") as renderer:
        assert isinstance(renderer, CpuRenderer)
        assert renderer.description.startswith("cpu")
    assert len(caplog.messages) == 1
    assert "\n" not in caplog.messages[0]
    assert "hidden by ABS_ENGINE_HIDE_GL" in caplog.messages[0]


def test_the_cpu_can_be_asked_for(caplog):
    with open_renderer("cpu") as renderer:
        assert isinstance(renderer, CpuRenderer)
    assert not caplog.messages


def test_an_unknown_name_is_refused():
    with pytest.raises(ParameterError, match="choose one of auto, gl, egl-device"):
        open_renderer("vulkan")
    with pytest.raises(OpenGLError, match="no OpenGL backend named"):
        GLContext.open("glx")


@pytest.mark.gl
def test_one_context_per_process(gl):
    with GLContext.open() as second:
        assert second is gl
    assert GLContext.of_process() is gl
    other = "osmesa" if gl.backend != "osmesa" else "egl-surfaceless"
    with pytest.raises(OpenGLError, match="open already"):
        GLContext.open(other)


@pytest.mark.gl
def test_another_thread_is_told_so_or_draws_on_the_cpu(gl, caplog):
    caught: list[Exception] = []
    drew: list[str] = []

    def use() -> None:
        try:
            OpenGLRenderer(gl)
        except OpenGLError as error:
            caught.append(error)
        with open_renderer("auto") as renderer:
            drew.append(renderer.description)

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert "another thread" in str(caught[0])
    assert drew[0].startswith("cpu")
    (line,) = caplog.messages
    assert line.startswith("the CPU draws, as this process's OpenGL belongs to another thread")


@pytest.mark.gl
def test_another_context_in_between_does_no_harm(gl):
    """What is current outside comes back after our calls, and our calls land in our context."""
    if not gl.backend.startswith("egl"):
        pytest.skip("two EGL contexts are needed")
    library = egl.load_egl()
    other = egl.open_surfaceless()
    try:
        theirs = library.eglGetCurrentContext()
        with gl.current():
            assert library.eglGetCurrentContext() != theirs
            buffer = gl.ctx.buffer(b"abcd")
            assert buffer.read() == b"abcd"
            buffer.release()
        assert library.eglGetCurrentContext() == theirs
    finally:
        other.release()


@pytest.mark.gl
def test_a_closed_context_is_refused():
    code = """
from abs_engine.render.context import GLContext
from abs_engine.core.errors import OpenGLError
for _ in range(3):  # opening again after closing works
    with GLContext.open() as gl:
        pass
    assert GLContext.of_process() is None
try:
    gl.current()
except OpenGLError as error:
    print(error)
"""
    done = in_process(code)
    assert "the OpenGL context is closed" in done.stdout, done.stderr


@pytest.mark.gl
def test_a_context_that_the_driver_loses_is_no_fault_of_threads():
    code = """
from abs_engine.render.egl import open_surfaceless
from abs_engine.core.errors import OpenGLError
lost = open_surfaceless()
lost._egl.eglMakeCurrent(lost._display, None, None, None)
lost._egl.eglDestroyContext(lost._display, lost._context)
try:
    with lost:
        print("current")
except OpenGLError as error:
    print(error)
"""
    if not exists("egl-surfaceless"):
        pytest.skip("EGL is needed")
    done = in_process(code)
    assert done.stdout.startswith("the driver has lost the OpenGL context"), done.stderr


@pytest.mark.gl
def test_a_context_is_not_taken_from_another_thread():
    code = """
from threading import Thread
from abs_engine.render.egl import open_surfaceless
from abs_engine.core.errors import OpenGLError
ours = open_surfaceless()
def elsewhere():
    try:
        ours.make_current()
    except OpenGLError as error:
        print(error)
thread = Thread(target=elsewhere)
thread.start()
thread.join()
"""
    if not exists("egl-surfaceless"):
        pytest.skip("EGL is needed")
    done = in_process(code)
    assert "current in another thread" in done.stdout, done.stderr


@pytest.mark.gl
def test_a_forked_child_is_refused():
    code = """
import os
from abs_engine.render.context import GLContext
from abs_engine.core.errors import OpenGLError
gl = GLContext.open()
child = os.fork()
if child == 0:
    try:
        gl.current()
    except OpenGLError:
        os._exit(7)
    os._exit(0)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    done = in_process(code)
    assert done.stdout.strip() == "7", done.stderr


def test_import_touches_neither_environment_nor_libraries():
    # Others may do as they like (cv2 sets LD_LIBRARY_PATH): what counts is the nearest caller that
    # is neither `os` nor `ctypes`. The last two lines show that the watch sees what it is for.
    code = """
import ctypes, os, sys
found = []
def watch(event, arguments):
    if event in ("os.putenv", "os.unsetenv", "ctypes.dlopen"):
        frame = sys._getframe(1)
        while frame and frame.f_globals.get("__name__") in ("os", "ctypes", "ctypes.util"):
            frame = frame.f_back
        name = frame.f_globals.get("__name__", "") if frame else ""
        if name.split(".")[0] in ("abs_engine", "__main__"):
            found.append((name, event, arguments))
sys.addaudithook(watch)
import abs_engine.render.select
assert not found, found
os.environ["ABS_ENGINE_WATCHED"] = "1"; ctypes.CDLL(None)
assert [event for _, event, _ in found] == ["os.putenv", "ctypes.dlopen"], found
"""
    done = in_process(code)
    assert done.returncode == 0, done.stderr


@pytest.mark.gl
@pytest.mark.parametrize(("given", "used"), [({}, "0"), ({"LP_NUM_THREADS": "1"}, "1")])
def test_llvmpipe_gets_no_threads_unless_the_user_says(given, used, monkeypatch):
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    code = """
import os
from abs_engine.render.context import GLContext
with GLContext.open():
    print(os.environ["LP_NUM_THREADS"])
"""
    assert in_process(code, **given).stdout.strip() == used
