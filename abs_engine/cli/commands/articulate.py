"""The `articulate` command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import note, opened
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    from abs_engine.capture.corpus import Corpus
    from abs_engine.face.shape.predictors import Predictor
    from abs_engine.face.talking import TalkingFace
    from abs_engine.learn.articulatory import Build
    from abs_engine.learn.measured.face import MeasuredFace
    from abs_engine.report.articulation.report import Heads

_NOTES = """\
Articulatory parameters by guided principal components: each one is the first component of some
coordinates of some points, in what the parameters before it leave unexplained of all points.
To see what each file looks like, start with a bundled speaker, whose folder has them all, as in the
first two examples.

CORPUS, points of a face in a posture for each viseme:
  C3D   markers, in the unit that the file states
  CSV   frame,point,x,y,z with a line for each point, or frame,NAME_x,NAME_y,NAME_z,... with a line
        for each frame; the cells of a missing point are empty, or all three 0
  NPZ   names (N) and points (T, N, 3), NaN where missing; or what 'observe -o' wrote; or a
        corpus.npz of this command, which needs no table
--roles, a CSV:                      or JSON:
  what,name,value                    {"groups": {"lips": ["m1", ...], ...},
  point,m1,lips upper_lip            "visemes": {"ipi": 12, "a": [30, 34]},
  viseme,ipi,12                      "upper_teeth": ["m80", "m81", "m82"]}
  viseme,a,30-34
  teeth,right,m80                    likewise left and front
  A point may be in several groups; one in no group is left out. Frames have the numbers in the
  CSV's column frame, also where observe wrote an NPZ of it, or else count from 0. Several
  frames of a viseme are averaged. teeth are three points of the upper teeth (a molar on either
  side, the front edge), by which the head's motion is removed; without them the points must
  already be in the frame of the upper teeth: x to the subject's left, y up, z forward. The usual
  predictors ask for the groups lips, upper_lip, lower_lip, jaw_line, lower_teeth and face (all
  but lips and teeth).
--predictors, a TOML file, if a language, a speaker or a set of points needs others:
  format = "abs_engine.predictors"
  version = 1
  [[predictor]]                      one for each parameter, in their order
  name = "jaw1"
  points = ["jaw_line", "m17"]       groups, or points
  coordinates = "y"                  of x, y and z
  positive = "-y"                    the direction in which the parameter grows

--face makes a face that can be drawn, for 'track --model'. A head is fitted to the viseme 'rest',
and face units and a smooth field carry the parameters over it. Any points will do, 12 or more, if
the groups lips, upper_lip, lower_lip and lower_teeth say which lie there; all other points that
are in some group lie on the skin.
Such a face is tracked by its colours; with --pictures it has textures and local appearance, too:
  picture,viseme,rx,ry,rz,tx,ty,tz
  ipi.png,ipi,3.1,0.02,0.01,4.2,11.5,640
  a.png,a,,,,,,
  Pictures lie beside the table, all of one camera. The pose is that of the frame of the upper
  teeth (a rotation vector in radians, mm) in the camera's axes: x right, y down, z forward. Where
  its cells are empty, or the columns missing, it is estimated.

--model writes curves of the parameters instead, for points named as in the model; see the last
example.
"""


@command(
    "Learn faces and lips",
    take.argument("corpus", "[CORPUS]", "recorded points, see below", required=False),
    take.output("DIR", "folder of the model, its tables and figures; with --model a CSV"),
    take.file("--roles", metavar="TABLE",
        text="which points are lips, jaw and teeth, and which frames are which viseme"),
    take.person("a bundled person's corpus instead; also writes it and its tables as CSV and "
        "TOML, and draws the head"),
    take.file("--predictors",
        "definitions of the parameters (default: Odisio and Bailly's)"),
    take.file("--model",
        "build no model, but write a CSV of this model.npz's parameters in each frame of CORPUS; "
        "of the table, only the upper teeth matter"),
    take.option("--face", type=take.PATH, metavar="FILE",
        text="also make a face of the corpus, for 'track --model'"),
    take.file("--pictures", metavar="TABLE",
        text="pictures of the visemes, from which the face's appearance is learned; see below"),
    take.file("--camera", "camera.json of the pictures' calibration"),
    take.option("--missing", type=take.Choice(("refuse", "drop", "impute")),
        text="points missing in some visemes: an error, left out, or filled in from the model of "
        "the others (default: refuse)"),
    take.option("--without", multiple=True, metavar="NAME",
        text="leave out a viseme or a point; may be repeated"),
    take.option("--unit", type=take.Choice(("mm", "cm", "m")),
        text="unit of CORPUS, if the file does not state it (default: mm)"),
    take.renderer(),
    examples="abs-engine articulate --person clara -o clara\n"
    "abs-engine articulate clara/points.csv --roles clara/roles.csv -o again\n"
    "abs-engine articulate mine.c3d --roles mine.csv -o mine --face me.face --pictures seen.csv\n"
    "abs-engine track talk.mp4 -o tracked --model me.face\n"
    "abs-engine articulate speech.c3d --roles mine.csv --model mine/model.npz -o speech.csv",
    notes=_NOTES,
)  # fmt: skip
def articulate(chosen: Chosen) -> Done:
    """Build an articulatory model of a corpus of visemes, or apply one."""
    check_free(chosen.output)
    if chosen.face is not None:
        check_free(chosen.face, take.FACE)
    _check(chosen)
    if chosen.model is not None:
        return _apply(chosen)
    if chosen.person is not None:
        return _of_person(chosen)
    from abs_engine.capture.corpus_file import read_corpus

    corpus = read_corpus(chosen.corpus, chosen.roles, unit=chosen.unit, say=note)
    return _finish(chosen, corpus, _predictors(chosen.predictors))


def _check(chosen: Chosen) -> None:
    if (chosen.corpus is None) == (chosen.person is None):
        both = "CORPUS and --person were given" if chosen.corpus else "there is no corpus"
        raise ParameterError(both, "name a file of recorded points, or a bundled --person")
    if chosen.person is not None and (chosen.roles or chosen.unit):
        raise ParameterError("--roles and --unit are for recorded points", "leave them out")
    building = chosen.person, chosen.predictors, chosen.missing, *chosen.without
    if chosen.model is not None and any(building):
        raise ParameterError(
            "--person, --predictors, --missing and --without are for building a model",
            "leave them out with --model",
        )
    if chosen.face is None and (chosen.pictures or chosen.camera):
        raise ParameterError("--pictures and --camera are for a face", "name its file with --face")
    if chosen.camera and not chosen.pictures:
        raise ParameterError("--camera is for pictures", "name their table with --pictures")
    if chosen.face is not None and chosen.face == chosen.output:
        raise ParameterError("--face and --output are the same", "give two names")
    if chosen.model is not None and chosen.face is not None:
        raise ParameterError("--face is for building a model", "leave it out with --model")


def _predictors(path: Path | None) -> tuple[Predictor, ...]:
    from abs_engine.face.shape.predictors import PAPER_PREDICTORS

    if path is None:
        return PAPER_PREDICTORS
    from abs_engine.report.articulation.predictor_file import read_predictors

    return read_predictors(path)


def _apply(chosen: Chosen) -> Done:
    from abs_engine.capture.corpus_file import read_recording
    from abs_engine.face.shape.articulatory_model import load_articulatory
    from abs_engine.report.articulation.applied import apply_model
    from abs_engine.report.articulation.model_page import applied_lines

    model = load_articulatory(chosen.model)
    spoken = read_recording(chosen.corpus, chosen.roles, chosen.unit, note)
    done = apply_model(model, spoken.names, spoken.points, spoken.first)
    write_new(chosen.output, done.as_csv().encode())
    return Done([*applied_lines(done), f"wrote {chosen.output}"], {"output": chosen.output})


def _of_person(chosen: Chosen) -> Done:
    from abs_engine.io.assets import load_speaker
    from abs_engine.report.articulation.report import Heads
    from abs_engine.studio.corpus import speak_corpus

    predictors, speaker = _predictors(chosen.predictors), load_speaker()
    spoken = speak_corpus(speaker, speaker.named(chosen.person))
    with opened(chosen.renderer) as renderer:
        heads = Heads(spoken, chosen.person, renderer)
        return _finish(chosen, spoken.corpus, predictors, heads)


def _finish(
    chosen: Chosen, corpus: Corpus, predictors: tuple[Predictor, ...], heads: Heads | None = None
) -> Done:
    from abs_engine.report.articulation.analysis import analyse
    from abs_engine.report.articulation.model_page import corpus_lines, error_lines, variance_lines
    from abs_engine.report.articulation.report import PAGE, write_report

    with Progress("articulate") as progress:
        progress.announce("building the model, and each time without one viseme")
        done = analyse(corpus, predictors, chosen.missing or "refuse", chosen.without)
        face = None
        if chosen.face is not None:
            progress.announce("fitting a head")
            face = _face(chosen, done.built, progress.announce)
        progress.announce("drawing")
        write_report(chosen.output, done, heads)
    lines = [*corpus_lines(done), *variance_lines(done), *error_lines(done)]
    if face is not None:
        from abs_engine.tracking.models.measured_looks import write_face

        lines += write_face(chosen.face, *face)
    lines.append(f"wrote {chosen.output}; open {chosen.output / PAGE}")
    return Done(lines, {"output": chosen.output, "lines": lines})


def _face(
    chosen: Chosen, built: Build, tell: Callable[[str], None]
) -> tuple[MeasuredFace, TalkingFace | None]:
    """The face of the corpus, and the same with the appearance of its pictures, if any."""
    from abs_engine.capture.viseme_pictures import read_viseme_pictures
    from abs_engine.dataset import load_camera
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.measured.face import measured_face
    from abs_engine.tracking.models.measured_looks import with_looks

    camera = None if chosen.camera is None else load_camera(chosen.camera)
    visemes = built.corpus.visemes
    table = None if chosen.pictures is None else read_viseme_pictures(chosen.pictures, visemes)
    made = measured_face(load_speaker(), built)
    if table is None:
        return made, None
    with opened(chosen.renderer) as renderer:
        return made, with_looks(made, built, table, camera, renderer, tell)
