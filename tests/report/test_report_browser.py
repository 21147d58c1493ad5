"""The report in headless Chromium: it opens from disk, plays, and complains of nothing."""

from __future__ import annotations

import base64
import itertools
from contextlib import contextmanager

import cv2
import numpy as np
import pytest
import reported
from browser import open_browser

from abs_engine.report.document import document, table
from abs_engine.report.gathering import ReportOptions, write_report

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with open_browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture(scope="module")
def pages(tmp_path_factory, browser):
    """Two runs and landmarks of another system by one truth; one run without any."""
    place = tmp_path_factory.mktemp("page")
    truth = reported.write_dataset(place / "data")
    runs = [reported.write_shifted(place / "shifted"), reported.write_exact(place / "exact")]
    marks = reported.write_landmarks(place / "marks.csv")
    write_report([*runs, marks], place / "scored.html", ReportOptions(truth))
    film = reported.write_film(place / "film.mp4")
    write_report(runs[1:], place / "plain.html", ReportOptions(video=film))
    uneven = reported.write_uneven(place / "uneven")
    write_report([uneven], place / "uneven.html", ReportOptions(video=film))
    return place


@pytest.fixture(scope="module")
def opened(browser, pages):
    if not browser.run("return document.title").startswith("kofi"):  # a test before has opened it
        browser.open(pages / "scored.html")
    return browser


@pytest.fixture
def page(opened):
    """The page with the truth, as if it were just opened; opening it each time takes long."""
    assert opened.run("return document.title").startswith("kofi")
    opened.run("""
        document.querySelector('[data-mode=beside]').click();
        document.querySelector('[data-yaw="0"]').click();
        const motion = document.getElementById('motion');
        if (motion.checked) motion.click();""")
    seek(opened, 0)
    opened.complaints()
    opened.said.clear()
    return opened


def canvas(browser, place):
    """The pixels of a canvas, (H, W, 3) RGB."""
    return decoded(browser.run(f"return document.querySelector('{place} canvas').toDataURL()"))


def decoded(address):
    """The picture that an address holds."""
    coded = np.frombuffer(base64.b64decode(address.partition(",")[2]), np.uint8)
    return cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1].astype(int)


def seek(browser, frame):
    """Move the slider, and wait for the picture."""
    browser.wait(
        "const s = document.getElementById('scrub'); const f = report.film;"
        "if (f) f.addEventListener('seeked', () => setTimeout(() => done(1), 50), { once: true });"
        f"s.value = {frame}; s.dispatchEvent(new Event('input')); if (!f) done(1);"
    )


def frame_of(grey):
    return (grey - reported.GREY) / reported.GREY_STEP


@contextmanager
def seen_on(browser, width, media=""):
    """The browser's pages on a phone, or on paper."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": not media}
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})
    try:
        yield
    finally:
        browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_wide_tables_are_printed_whole(browser, tmp_path):
    head = ("model", "all, mm", "lips, mm", "along z, mm", "worst sentence, mm", "evaluations")
    rows = [("la_lin, as printed", "0.378", "0.526", "0.335", "0.452", "249.1")]
    body = table([*head, *head[1:]], [(*row, *row[1:]) for row in rows])
    (tmp_path / "page.html").write_text(document("sentences", body))
    with seen_on(browser, 718, "print"):  # A4 within Chromium's margins
        browser.driver.get((tmp_path / "page.html").as_uri())
        wide, shown = browser.run("""
            const e = document.querySelector('.wide'); return [e.scrollWidth, e.clientWidth];""")
    assert wide <= shown


def test_a_film_of_uneven_frames_is_played_at_their_times(browser, pages):
    browser.open(pages / "uneven.html")
    for frame in (reported.PAUSED - 1, reported.PAUSED, 25):
        seek(browser, frame)
        assert browser.run("return report.frame") == frame
        assert frame_of(canvas(browser, ".film")[4, 4].mean()) == pytest.approx(frame, abs=0.6)
    assert browser.run("return document.getElementById('where').textContent") == "frame 25, 3.50 s"
    seek(browser, 0)
    seen = browser.wait("""
        const drawn = document.querySelector('.film canvas'), seen = [];
        document.getElementById('play').click();
        (function look() {
          const c = drawn.getContext('2d').getImageData(4, 4, 1, 1).data;
          seen.push([report.frame, c[0], report.film.currentTime]);
          if (report.frame < 20) requestAnimationFrame(look); else done(seen);
        })();""")
    browser.run("document.getElementById('play').click()")
    frames, greys, times = np.array(seen).T
    assert len(set(frames)) > 3  # the fewer, the slower the machine
    assert np.abs(frame_of(greys) - frames).max() < 1.5
    late = times - frames / 25 - np.where(frames < reported.PAUSED, 0, reported.PAUSE)
    assert late.min() > -0.2
    # a busy browser leaves frames out, the one on which the film stands still among them
    moves_again = reported.PAUSED / 25 + reported.PAUSE
    still = (times > (reported.PAUSED - 1) / 25) & (times < moves_again + 0.2)
    assert late[~still | (frames >= reported.PAUSED)].max() < 0.2


@pytest.mark.parametrize("name", ["plain", "scored"])
def test_it_opens_from_disk_without_network_or_complaint(browser, pages, name):
    browser.open(pages / f"{name}.html")
    browser.run("window.scrollTo(0, document.documentElement.scrollHeight)")
    assert browser.complaints() == []
    assert browser.strange_requests() == set()
    assert browser.run("return !!report.stage && report.film.readyState > 0")
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    seek(browser, 12)
    assert frame_of(canvas(browser, ".film")[4, 4].mean()) == pytest.approx(12, abs=0.6)
    hidden = "[...document.querySelectorAll('.no-webgl')].every((note) => note.hidden)"
    assert browser.run(f"return {hidden}")


def test_the_policy_lets_nothing_out(page):
    asked = "fetch('https://example.org/').then(() => done('out'), () => done('held'))"
    assert page.wait(asked) == "held"
    assert any("Content Security Policy" in text for _, text in page.complaints())


def test_charts_of_all_systems_are_drawn(page):
    count = "return document.querySelectorAll('#chart-{} .{}').length"
    # truth, two runs and the landmarks for aperture, width and protrusion; then errors by rows
    assert page.run(count.format("lips", "scatterlayer .js-line")) >= 3 * 3
    assert page.run(count.format("errors", "scatterlayer .js-line")) >= 5 * 2
    assert page.run(count.format("boxes", "trace.boxes")) >= 5 * 2


def test_equal_curves_are_told_apart(page):
    """The exact run lies on the truth: both are seen, and so is a third in the same place."""
    strokes = page.run("""
        const rows = document.querySelectorAll('#chart-lips .scatterlayer .js-line');
        return [...rows].map((r) => [r.style.stroke, r.style.strokeWidth, r.style.strokeDasharray]);
    """)
    by_colour = {colour: (float(width[:-2]), dash) for colour, width, dash in strokes}
    assert len(by_colour) >= 3
    truth, shifted, exact = list(by_colour.values())[:3]
    assert truth[0] > shifted[0] + 2 > exact[0] + 2
    assert exact[1] != shifted[1]
    legend = "return [...document.querySelectorAll('.legend line')].map((l) => l.outerHTML)"
    assert len(set(page.run(legend))) == 4


def test_contours_on_the_video_have_the_dashes_of_the_curves(page):
    dashes = page.run("return told.contours.map((one) => one.stroke.dash.join())")
    assert dashes[:2] == ["", ""]
    assert len(set(dashes[1:])) == len(dashes) - 1


def test_an_old_browser_is_told_so(browser, pages):
    """What the page does where nothing can be inflated."""
    asked = """
        const old = window.DecompressionStream, note = document.querySelector('.too-old');
        delete window.DecompressionStream;
        start().then(() => {
          const seen = !note.hidden;
          note.hidden = true;
          window.DecompressionStream = old;
          done(seen);
        });"""
    assert browser.wait(asked)


def test_it_plays(page):
    before = canvas(page, ".stage")
    page.run("document.getElementById('play').click()")
    assert page.run("return report.playing")
    address, time = page.wait("""
        (function look() {
          const c = document.querySelector('.stage canvas');
          if (report.frame > 14) done([c.toDataURL(), report.film.currentTime]);
          else requestAnimationFrame(look);
        })();""")
    assert time > 0.5
    assert np.abs(decoded(address) - before).max() > 20
    page.run("document.getElementById('play').click()")
    assert not page.run("return report.playing")
    assert page.complaints() == []


def test_heads_and_contours_are_those_of_the_picture_while_it_plays(page):
    """Each picture that is drawn is compared with the frame that the page believes to show."""
    seen = page.wait("""
        const drawn = document.querySelector('.film canvas'), seen = [];
        document.getElementById('play').click();
        (function look() {
          const c = drawn.getContext('2d').getImageData(4, 4, 1, 1).data;
          seen.push([report.frame, c[0]]);
          const shown = new Set(seen.map(([frame]) => frame)).size;  // few on a slow machine
          if (seen.length < 30 || shown < 6) requestAnimationFrame(look); else done(seen);
        })();""")
    frames, greys = np.array(seen).T
    assert np.abs(frame_of(greys) - frames).max() < 1.5  # half of it the film's compression


def test_the_slider_goes_to_a_frame(page):
    seek(page, 5)
    before = canvas(page, ".stage")
    seek(page, 20)
    assert page.run("return report.frame") == 20
    assert (
        page.run("return document.getElementById('where').textContent") == "frame 20, 0.80 s, /a/"
    )
    assert frame_of(canvas(page, ".film")[4, 4].mean()) == pytest.approx(20, abs=0.6)
    assert np.abs(canvas(page, ".stage") - before).max() > 20
    line = "document.querySelector('#chart-lips .cursor').style.left"
    at = float(page.run(f"return {line}")[:-2])
    seek(page, 10)
    assert float(page.run(f"return {line}")[:-2]) < at


def test_a_lost_frame_is_said_to_be_lost(page):
    seek(page, reported.LOST)
    tags = page.run(
        "return [...document.querySelectorAll('.stage .tag')].map((t) => t.textContent)"
    )
    assert tags == ["truth", "shifted: lost", "exact"]


def test_heads_turn_with_the_mouse(page):
    before = canvas(page, ".stage")
    page.run("""
        const c = document.querySelector('.stage canvas');
        c.setPointerCapture = () => {};
        const at = (kind, x) => c.dispatchEvent(
          new PointerEvent(kind, { clientX: x, clientY: 10, pointerId: 1 }));
        at('pointerdown', 10); at('pointermove', 90); at('pointerup', 90);""")
    assert page.run("return report.stage.view.turn.yaw") == pytest.approx(0.64)
    assert np.abs(canvas(page, ".stage") - before).max() > 20


def test_errors_are_painted_in_the_colours_of_the_scale(page):
    """One run is wrong by half of the scale everywhere, the other by nothing."""
    page.run("document.querySelector('[data-mode=error]').click()")
    drawn = canvas(page, ".stage")
    height, width = drawn.shape[:2]
    shifted, exact = drawn[height // 2, width // 4], drawn[height // 2, 3 * width // 4]
    # viridis: from violet, whose green is nearly none, to yellow, whose blue is nearly none
    assert exact[1] < 60 < exact[2]
    assert shifted[1] > 100
    mapped = canvas(page, ".maps")
    height, width = mapped.shape[:2]
    assert mapped[3 * height // 4, width // 2][1] < 60
    assert mapped[height // 4, width // 2][1] > 100
    page.run("""
        const s = document.getElementById('scale');
        s.value = '20'; s.dispatchEvent(new Event('change'));""")
    assert canvas(page, ".maps")[height // 4, width // 2][1] < 100
    ticks = page.run("return [...document.querySelectorAll('.ticks span')].map(t => t.textContent)")
    assert ticks == ["0", "5", "10", "15", "20+"]


@pytest.mark.parametrize("mode", ["over", "beside"])
def test_modes_draw_different_pictures(page, mode):
    page.run("document.querySelector('[data-mode=error]').click()")
    before = canvas(page, ".stage")
    page.run(f"document.querySelector('[data-mode={mode}]').click()")
    page.run("document.getElementById('motion').click()")
    after = canvas(page, ".stage")
    assert before.shape != after.shape or np.abs(before - after).max() > 20


def test_titles_of_the_boxes_can_be_read_on_a_phone(page):
    """None lies over another, nor under the buttons of the chart."""
    with seen_on(page, 390):
        page.wait("Plotly.Plots.resize('chart-boxes').then(() => done(1))")
        places = page.run("""
            const all = document.querySelectorAll('#chart-boxes :is(.annotation-text, .modebar)');
            return [...all].map((e) => e.getBoundingClientRect().toJSON());""")
    assert len(places) >= 6
    for one, other in itertools.combinations(places, 2):
        beside = one["right"] <= other["left"] or other["right"] <= one["left"]
        assert beside or one["bottom"] <= other["top"] or other["bottom"] <= one["top"]


def test_buttons_of_charts_are_not_printed(page):
    asked = "return getComputedStyle(document.querySelector('.modebar')).display"
    assert page.run(asked) != "none"
    with seen_on(page, 718, "print"):
        assert page.run(asked) == "none"


def test_a_worst_frame_leads_to_its_frame(page):
    frame = page.run(
        "const i = document.querySelector('[data-frame]'); i.click(); return i.dataset.frame"
    )
    assert page.run("return report.frame") == int(frame)
