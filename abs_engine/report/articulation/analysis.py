"""A corpus, a user's own or a bundled speaker's, made into an articulatory model."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from abs_engine.capture.corpus import Corpus
from abs_engine.core.provenance import made_by
from abs_engine.face.shape.articulatory import Missing
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.articulatory import Build, LeftOut, build, leave_out_in_turn
from abs_engine.report.articulation.tables import results


@dataclass(frozen=True, eq=False)
class Analysis:
    """A model, what it was built of, and how it does on visemes that it was not built of.

    Parameters
    ----------
    asked : tuple of str
        Points and visemes that were to be kept out.
    roleless : tuple of str
        Points that were kept out as they are in no group and of no predictor.
    unseen : LeftOut
        Errors of each viseme in the model of the others, and the visemes that could not be left
        out: where the others are too few, lack a point or leave a predictor nothing to explain, or
        the viseme's own points are too few.
    """

    built: Build
    asked: tuple[str, ...]
    roleless: tuple[str, ...]
    unseen: LeftOut

    @property
    def guessed(self) -> dict[str, int]:
        """Imputed points that fewer visemes show than there are parameters, and how many do.

        Where such a point goes with the parameters is not determined.
        """
        count = len(self.built.corpus)
        shown = {name: count - gaps for name, gaps in self.built.imputed.items()}
        return {n: k for n, k in shown.items() if k < len(self.built.model.parameters)}

    def as_json(self) -> dict[str, Any]:
        """Content of results.json: see `tables.results`; names of what was kept out or imputed."""
        built = self.built
        errors = zip(built.corpus.visemes, built.viseme_errors, strict=True)
        return results(built, self.unseen.errors) | {
            "source": built.model.source,
            **made_by(),
            "points": len(built.model.names),
            "visemes": len(built.corpus),
            "kept_out": {
                "asked": list(self.asked),
                "in_no_group": list(self.roleless),
                "missing": list(built.left_out),
            },
            "imputed": dict(built.imputed),
            "not_left_out": {v: error.problem for v, error in self.unseen.skipped.items()},
            "viseme_rms_mm": {viseme: float(error) for viseme, error in errors},
        }


def analyse(
    corpus: Corpus,
    predictors: Sequence[Predictor] = PAPER_PREDICTORS,
    missing: Missing = "refuse",
    without: Collection[str] = (),
) -> Analysis:
    """Build the model of those points of a corpus that have a role, and measure it.

    Parameters
    ----------
    missing : {"refuse", "drop", "impute"}
        What to do with points that are missing in some visemes; see `GuidedPCA`.
    without : collection of str
        Points and visemes to keep out.

    Raises
    ------
    TooFewPointsError
        If points are missing and may not be, a predictor has none, or there are not more visemes
        than parameters.
    ParameterError
        If a name is unknown, a predictor asks for an unknown group, or finds nothing left to
        explain.
    """
    corpus = corpus.without(without)
    named = {name for predictor in predictors for name in predictor.points}
    roleless = tuple(name for name in corpus.roleless if name not in named)
    corpus = corpus.without(roleless)
    built = build(corpus, predictors, missing)
    unseen = leave_out_in_turn(corpus, predictors, missing)
    return Analysis(built, tuple(dict.fromkeys(without)), roleless, unseen)
