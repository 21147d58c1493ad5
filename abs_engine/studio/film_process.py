"""A process that films: reads jobs from standard input, a line each, and tells what it has done.

It ends when its standard input is closed, so with the process that started it.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path
from typing import Any, TextIO

from abs_engine.core.errors import AbsEngineError, OutputError
from abs_engine.io.assets import load_speaker
from abs_engine.io.files import unwritable
from abs_engine.studio.chunk import Filmer, Job


def main(words: list[str]) -> None:
    """Film what comes; `words` are the journal's folder, the head's file and the labels."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; the first process decides
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what a library prints must not end up among the answers
    work, speaker = Path(words[0]), load_speaker(Path(words[1]))
    with Filmer(work, speaker, tuple(words[2:])) as filmer:
        for line in sys.stdin:
            _film(filmer, Job(**json.loads(line)), answers, work)


def _film(filmer: Filmer, job: Job, answers: TextIO, work: Path) -> None:
    try:
        filmer.film(job, lambda: _tell(answers, frame=1))
    except BrokenPipeError:  # nobody listens any more
        raise SystemExit(1) from None
    except AbsEngineError as error:
        _tell(answers, error=[type(error).__name__, error.problem, error.remedy])
    except OSError as error:
        failed = unwritable(work, error)
        _tell(answers, error=[OutputError.__name__, failed.problem, failed.remedy])
    else:
        _tell(answers, done=job.name)


def _tell(answers: TextIO, **message: Any) -> None:
    answers.write(json.dumps(message) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
