"""The commands. No mathematics here."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType

from abs_engine.cli.parser import build_parser
from abs_engine.core.errors import AbsEngineError

BAD_INPUT, INTERRUPTED, NOT_READ = 2, 130, 141


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the process.

    Returns
    -------
    int
        0; 2 when the input or the machine is at fault, with one line on stderr; 130 when
        interrupted; 141, without a word, when what reads stdout (such as `head`) has closed it.
    """
    try:
        try:
            return _run(arguments)
        finally:
            print(
                end="", flush=True
            )  # so that a closed pipe shows here, not as the interpreter ends
    except BrokenPipeError:
        if not _nobody_reads():
            raise
        _let_stdout_go()
        return NOT_READ


def _run(arguments: Sequence[str] | None) -> int:
    parser = build_parser()
    chosen = parser.parse_args(arguments)
    if chosen.command is None:
        parser.print_help()
        return BAD_INPUT
    try:
        with _sigterm_as_interrupt():
            return int(chosen.run(chosen))
    except AbsEngineError as error:
        line = " ".join(str(error).split())
        print(f"abs-engine: error: {line}", file=sys.stderr)
        return BAD_INPUT
    except MemoryError:
        print(
            "abs-engine: error: there is not enough memory; ask for a smaller size", file=sys.stderr
        )
        return BAD_INPUT
    except KeyboardInterrupt as stop:
        what = str(stop) or "nothing was left behind"
        print(f"abs-engine: interrupted; {what}", file=sys.stderr)
        return INTERRUPTED


def _nobody_reads() -> bool:
    """Whether stdout is the pipe that broke, not that to a process of our own."""
    try:
        print(flush=True)  # not empty, which an unbuffered stdout would not try to write
    except BrokenPipeError:
        return True
    return False


def _let_stdout_go() -> None:
    """Send to nowhere what the interpreter still wants to write as it ends."""
    with suppress(OSError, ValueError):  # a stdout without a file has nothing to send
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def _sigterm_as_interrupt() -> Iterator[None]:
    """End on SIGTERM as on Ctrl-C, so that half-written output is removed."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _stop(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
