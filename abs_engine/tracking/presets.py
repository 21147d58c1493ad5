"""Choices of model, evidence, driver and start that belong together, by name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.core.registry import MODELS, PRESETS, nearest
from abs_engine.fit.terms import bends, term_kinds
from abs_engine.io.npz import read_kind
from abs_engine.tracking.frame.mouth_landmarks import LANDMARKS as BY_LANDMARKS
from abs_engine.tracking.model_entry import Prepare, model_named
from abs_engine.tracking.options import LANDMARKS, TrackOptions

MODEL_OF_FORMAT = {
    "abs_engine.learned_physics": "shell",
    "abs_engine.talking_face": "talking",
    "abs_engine.speaker_face": "speaker",
    "abs_engine.speaker": "head",
    "abs_engine.worn_mouths": "worn",
}
"""The model that each format of file is of."""


@dataclass(frozen=True)
class Preset:
    """A choice that belongs together: an entry of `core.registry.PRESETS`.

    Parameters
    ----------
    summary : str
        What it is, in a line.
    model : str
        Of `core.registry.MODELS`.
    terms : tuple of str
    driver : str
    start : str
    prepare : callable, optional
        How a clip is made ready, where not as the model's own entry does.
    """

    summary: str
    model: str
    terms: tuple[str, ...]
    driver: str
    start: str
    prepare: Prepare | None = None


USUAL = Preset(
    "what is used where nothing is chosen", "head", ("colour", "shading"), "newton", LANDMARKS
)
CLOSE_UP = Preset("a camera worn before the mouth", "worn", ("opening",), "newton", LANDMARKS)
HEADS = (USUAL.model, "speaker")
"""Models that colours alone move by their borders, and whose skin's shading is compared."""
WITH_HEAD = ("speaker", "talking")
"""Models whose file holds the head that they were learned on."""


def resolved(options: TrackOptions) -> tuple[TrackOptions, Prepare]:
    """The options with nothing left open, and what makes a clip ready by them.

    Explicit choices take precedence over a preset, except for a model of another kind, to which the
    rest of the preset would not apply.

    Raises
    ------
    InputFileError, ModelFormatError
        If a model's file cannot be read.
    ParameterError
        If there is no preset or model of such a name, or they do not go together.
    PluginError
        If one cannot be imported.
    """
    preset: Preset = USUAL if options.preset is None else PRESETS.get(options.preset)
    name = options.model or (CLOSE_UP if options.worn else preset).model
    file = _file(name)
    kind = name if file is None else model_of_file(file)
    _check_kind(options, preset, kind)
    if options.preset is None and kind == CLOSE_UP.model:
        preset = CLOSE_UP
    if file is not None and kind == USUAL.model:
        if options.speaker is not None:
            raise ParameterError(
                f"--speaker does nothing for {file}, which is a head itself", "leave out --speaker"
            )
        options = replace(options, speaker=file)
    if file is not None and kind == "shell" and options.physics is not None:
        raise ParameterError("two files say how the lips move", "leave out --physics, or --model")
    terms = _terms(options, preset, kind) if options.terms is None else options.terms
    chosen = replace(
        options,
        model=kind,
        model_file=file,
        terms=terms,
        driver=options.driver or _driver(preset, kind, terms),
        start=options.start or preset.start,
    )
    prepare: Prepare = preset.prepare or model_named(kind)
    return chosen, prepare


def _check_kind(options: TrackOptions, preset: Preset, kind: str) -> None:
    """Raise `ParameterError` for a kind of model that is not of a worn camera, or of a preset."""
    if options.worn and kind != CLOSE_UP.model:
        raise ParameterError(
            f"a close-up of a mouth is not tracked by the model '{kind}'",
            "leave out --worn, or give the file that 'mouths' learned with --model",
        )
    if options.preset is not None and kind != preset.model:
        other = "--worn" if options.worn else "--model"
        raise ParameterError(
            f"the preset '{options.preset}' is for the model '{preset.model}', not for '{kind}'",
            f"leave out --preset, or {other}",
        )


def _terms(options: TrackOptions, preset: Preset, kind: str) -> tuple[str, ...]:
    """The preset's evidence; of the usual, colour alone where shading was not measured."""
    placed = options.start in (None, LANDMARKS) or options.person is not None
    drawn = options.evidence != BY_LANDMARKS
    if preset is not USUAL or (kind in HEADS and placed and drawn):
        return preset.terms
    return preset.terms[:1]


def _driver(preset: Preset, kind: str, terms: tuple[str, ...]) -> str:
    """The preset's driver, or one that serves any face and evidence where the usual does not."""
    if preset is USUAL and not (kind in HEADS and bends(term_kinds(terms))):
        return "simplex"
    return preset.driver


def _file(name: str) -> Path | None:
    """The file that a model is named by; None where it is named by its kind."""
    if name in MODELS:
        return None
    path = Path(name)
    if path.suffix or len(path.parts) > 1:
        return path
    raise ParameterError(f"there is no model or file '{name}'", nearest(name, MODELS))


def model_of_file(path: Path) -> str:
    """The kind of model that a file holds, of `core.registry.MODELS`.

    Raises
    ------
    InputFileError
        If it cannot be read.
    ModelFormatError
        If it is of no model.
    """
    writers = "'import', 'train', 'articulate' or 'mouths'"
    wanted = f"give a face that 'speaker' learned, or a file that {writers} wrote"
    found = read_kind(path, f"if it is a model, check that it is whole; else {wanted}")
    if found not in MODEL_OF_FORMAT:
        raise ModelFormatError(f"{path} holds no model but {found}", wanted)
    return MODEL_OF_FORMAT[found]
