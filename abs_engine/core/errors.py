"""The exceptions a user can meet. Each message says what is wrong and what to do."""

from __future__ import annotations


class AbsEngineError(Exception):
    """Base of every error that is the input's or the machine's fault, not a bug.

    Parameters
    ----------
    problem : str
        What is wrong, in one line.
    remedy : str
        What to do about it, in one line.
    """

    def __init__(self, problem: str, remedy: str) -> None:
        self.problem, self.remedy = _one_line(problem), _one_line(remedy)
        super().__init__(self.problem, self.remedy)

    def __str__(self) -> str:
        return f"{self.problem}; {self.remedy}"


def _one_line(text: str) -> str:
    """Text in one line that a terminal can show: it may quote a file that means harm."""
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(c if c.isprintable() else "?" for c in line)


class InputFileError(AbsEngineError):
    """A file is missing, empty, or not of the kind that was asked for."""


class VideoError(InputFileError):
    """A video cannot be opened, breaks off, or holds no frames."""


class ModelFormatError(InputFileError):
    """A model file has another format or version than this release reads."""


class MeshError(AbsEngineError):
    """A mesh holds NaN, wrong indices, or no area at all."""


class ParameterError(AbsEngineError):
    """A value is outside of what the function accepts."""


class OtherClipError(ParameterError):
    """A result is of another clip than the ground truth that it is compared with."""


class FaceNotFoundError(AbsEngineError):
    """No face, or no mouth, was found in the frames."""


class TooFewPixelsError(AbsEngineError):
    """A colour class has too few pixels to be learned from."""


class OutputError(AbsEngineError):
    """An output folder or file exists already or cannot be written."""


class SameOutputError(OutputError):
    """An output already exists and is complete, and the same command made it."""


class BusyOutputError(OutputError):
    """Another process makes an output right now."""


class OpenGLError(AbsEngineError):
    """No OpenGL context of the wanted kind can be made on this machine."""


class StudioError(AbsEngineError):
    """The studio's worker process failed."""


class CalibrationError(AbsEngineError):
    """Pictures of a calibration board do not determine the cameras."""


class OtherPersonError(AbsEngineError):
    """Recordings that should show one person show several."""


class TooFewFramesError(AbsEngineError):
    """Recordings hold too few frames, or too little variety, to learn from."""


class TooFewPointsError(AbsEngineError):
    """Points are missing that a step cannot do without."""


class DegenerateViewsError(AbsEngineError):
    """Views, or points, lie so that depth or rotation cannot be found from them."""


class PictureError(AbsEngineError):
    """A picture holds NaN or infinity, or has another size than its camera."""


class NothingSeenError(AbsEngineError):
    """No training frame shows any part of what an appearance model is to be learned of."""


class PluginError(AbsEngineError):
    """An entry of a registry cannot be imported, or is not what such an entry must be."""


class TermError(AbsEngineError):
    """Evidence that cannot be computed, or is not finite."""


class OutOfPictureError(ParameterError):
    """The region to compare lies outside of the picture."""
