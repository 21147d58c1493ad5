"""3D face and lip motion in video by analysis by synthesis.

The names below are the public interface; what else is in the package may change. Each is imported
when it is first used, so that `import abs_engine` takes no time.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from abs_engine.core.compile_cache import find_cache

if TYPE_CHECKING:
    from abs_engine.capture.corpus_file import read_corpus
    from abs_engine.core.buffers import Buffers
    from abs_engine.core.camera import Camera, Window
    from abs_engine.core.errors import AbsEngineError
    from abs_engine.core.geometry import Mesh, Pose
    from abs_engine.core.objective import Evaluation
    from abs_engine.core.params import ParamSpec
    from abs_engine.core.registry import (
        DRIVERS,
        EXPORTERS,
        METRICS,
        MODELS,
        PRESETS,
        RENDERERS,
        TERMS,
    )
    from abs_engine.core.scene import Candidates, ClassMaps, ColourError, Renderer, Scene
    from abs_engine.dataset import Dataset, Truth, load_dataset, load_truth
    from abs_engine.evaluate.bench import run_bench
    from abs_engine.evaluate.catalogue import Metric
    from abs_engine.evaluate.check import check_dataset
    from abs_engine.evaluate.truth_report import score
    from abs_engine.export.exporter import Exporter, Loss, TrackedRun
    from abs_engine.export.writing import export_run
    from abs_engine.face.base import Face
    from abs_engine.face.shape.articulatory import GuidedPCA
    from abs_engine.face.shape.articulatory_model import ArticulatoryModel, load_articulatory
    from abs_engine.face.shape.predictors import Predictor
    from abs_engine.fit.problem import Problem
    from abs_engine.fit.terms import TermKind
    from abs_engine.fit.view import View
    from abs_engine.io.assets import Speaker, load_speaker
    from abs_engine.io.video.frames_file import write_video
    from abs_engine.optimise.base import Solution
    from abs_engine.optimise.by_nlopt import Simplex
    from abs_engine.optimise.drivers import Driver
    from abs_engine.render.diagnose import diagnose
    from abs_engine.render.select import open_renderer
    from abs_engine.report.demo import DemoOptions, film_clip, run_demo
    from abs_engine.report.gathering import ReportOptions, write_report
    from abs_engine.studio.filming import film_scene
    from abs_engine.studio.scenefile import SceneFile, read_scene
    from abs_engine.tracking.api import track
    from abs_engine.tracking.frame.clip_setting import FrameResult
    from abs_engine.tracking.models.heads import prepare_head
    from abs_engine.tracking.options import TrackOptions
    from abs_engine.tracking.presets import Preset
    from abs_engine.tracking.results.run_mesh import load_mesh
    from abs_engine.tracking.run import prepare, track_video
    from abs_engine.tracking.run_in_memory import Run
    from abs_engine.tracking.runs.record import load_run

_HOME = {
    # what is drawn, and by what
    "Speaker": "io.assets",
    "load_speaker": "io.assets",
    "Mesh": "core.geometry",
    "Pose": "core.geometry",
    "Camera": "core.camera",
    "Window": "core.camera",
    "Scene": "core.scene",
    "Candidates": "core.scene",
    "ClassMaps": "core.scene",
    "ColourError": "core.scene",
    "Renderer": "core.scene",
    "Buffers": "core.buffers",
    "open_renderer": "render.select",
    "Simplex": "optimise.by_nlopt",
    # the lips in a video
    "track": "tracking.api",
    "write_video": "io.video.frames_file",
    "Run": "tracking.run_in_memory",
    "track_video": "tracking.run",
    "TrackOptions": "tracking.options",
    "prepare": "tracking.run",
    "FrameResult": "tracking.frame.clip_setting",
    "load_run": "tracking.runs.record",
    "load_mesh": "tracking.results.run_mesh",
    # articulatory parameters of a speaker's own corpus
    "read_corpus": "capture.corpus_file",
    "Predictor": "face.shape.predictors",
    "GuidedPCA": "face.shape.articulatory",
    "ArticulatoryModel": "face.shape.articulatory_model",
    "load_articulatory": "face.shape.articulatory_model",
    # clips with known truth
    "film_clip": "report.demo",
    "run_demo": "report.demo",
    "DemoOptions": "report.demo",
    "Truth": "dataset",
    "load_truth": "dataset",
    "Dataset": "dataset",
    "load_dataset": "dataset",
    "check_dataset": "evaluate.check",
    "SceneFile": "studio.scenefile",
    "read_scene": "studio.scenefile",
    "film_scene": "studio.filming",
    "ReportOptions": "report.gathering",
    "write_report": "report.gathering",
    "score": "evaluate.truth_report",
    # what can be chosen by name, and what one's own is made of
    "MODELS": "core.registry",
    "TERMS": "core.registry",
    "DRIVERS": "core.registry",
    "RENDERERS": "core.registry",
    "PRESETS": "core.registry",
    "EXPORTERS": "core.registry",
    "METRICS": "core.registry",
    "Metric": "evaluate.catalogue",
    "Exporter": "export.exporter",
    "TrackedRun": "export.exporter",
    "Loss": "export.exporter",
    "export_run": "export.writing",
    "Face": "face.base",
    "View": "fit.view",
    "TermKind": "fit.terms",
    "Problem": "fit.problem",
    "ParamSpec": "core.params",
    "Evaluation": "core.objective",
    "Driver": "optimise.drivers",
    "Solution": "optimise.base",
    "Preset": "tracking.presets",
    "prepare_head": "tracking.models.heads",
    # the machine
    "diagnose": "render.diagnose",
    "run_bench": "evaluate.bench",
    "AbsEngineError": "core.errors",
}

__all__ = [
    "DRIVERS",
    "EXPORTERS",
    "METRICS",
    "MODELS",
    "PRESETS",
    "RENDERERS",
    "TERMS",
    "AbsEngineError",
    "ArticulatoryModel",
    "Buffers",
    "Camera",
    "Candidates",
    "ClassMaps",
    "ColourError",
    "Dataset",
    "DemoOptions",
    "Driver",
    "Evaluation",
    "Exporter",
    "Face",
    "FrameResult",
    "GuidedPCA",
    "Loss",
    "Mesh",
    "Metric",
    "ParamSpec",
    "Pose",
    "Predictor",
    "Preset",
    "Problem",
    "Renderer",
    "ReportOptions",
    "Run",
    "Scene",
    "SceneFile",
    "Simplex",
    "Solution",
    "Speaker",
    "TermKind",
    "TrackOptions",
    "TrackedRun",
    "Truth",
    "View",
    "Window",
    "check_dataset",
    "diagnose",
    "export_run",
    "film_clip",
    "film_scene",
    "load_articulatory",
    "load_dataset",
    "load_mesh",
    "load_run",
    "load_speaker",
    "load_truth",
    "open_renderer",
    "prepare",
    "prepare_head",
    "read_corpus",
    "read_scene",
    "run_bench",
    "run_demo",
    "score",
    "track",
    "track_video",
    "write_report",
    "write_video",
]  # fmt: skip


find_cache()  # before anything imports numba


def __getattr__(name: str) -> Any:
    """The public name, imported from where it lives."""
    if name not in _HOME:
        raise AttributeError(f"module 'abs_engine' has no attribute '{name}'")
    return getattr(import_module(f"abs_engine.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """The public names."""
    return sorted(__all__)
