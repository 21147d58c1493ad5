"""The commands. No mathematics here."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TextIO

import click

from abs_engine.cli.parts.progress import log
from abs_engine.cli.program import NAME, PROGRAM, complaint
from abs_engine.core.errors import AbsEngineError
from abs_engine.core.garbage import collect_seldom

BAD_INPUT, INTERRUPTED, NOT_READ = 2, 130, 141
_OF_DISKS = errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO, errno.EFBIG
_ENDING = signal.SIGTERM, signal.SIGHUP
COMPLETE = "_ABS_ENGINE_COMPLETE"


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
    _open_what_is_closed()
    if arguments is None:
        collect_seldom()
    if isinstance(sys.stdout, io.TextIOWrapper):  # names of files may be no text
        sys.stdout.reconfigure(errors="backslashreplace")
    status = 0
    try:
        status = _run(arguments)
        print(end="", flush=True)  # so that a closed pipe shows here, not as the interpreter ends
        return status
    except OSError as error:
        if not _is_lost():
            raise
        _let_go(sys.stdout)
        if isinstance(error, BrokenPipeError):
            return NOT_READ
        return status or _complain(
            f"stdout cannot be written ({error.strerror}); send it elsewhere"
        )
    finally:
        try:
            sys.stderr.flush()
        except (OSError, ValueError):
            _let_go(sys.stderr)


def _run(arguments: Sequence[str] | None) -> int:
    try:
        with _ended_as_interrupted():
            return _command(list(sys.argv[1:] if arguments is None else arguments))
    except AbsEngineError as error:
        return _complain(str(error))
    except MemoryError:
        return _complain("there is not enough memory; ask for a smaller size")
    except OSError as error:
        if _is_lost() or error.errno not in _OF_DISKS:
            raise
        where = error.filename or "temporary files"
        return _complain(f"{where} cannot be written ({error.strerror}); free space there")
    except click.exceptions.Exit as end:  # after --help and --version
        return end.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        print(error.format_message())
        return BAD_INPUT
    except click.ClickException as error:
        return _complain(complaint(error))
    except (KeyboardInterrupt, SystemError) as stop:
        # A compiled loop that is interrupted as it ends raises a SystemError that was caused by it
        asked = stop.__cause__ if isinstance(stop, SystemError) else stop
        if not isinstance(asked, KeyboardInterrupt):
            raise
        kept = f"; {asked}" if str(asked) else ""
        log(f"abs-engine: interrupted{kept}\n")
        return INTERRUPTED


def _command(words: list[str]) -> int:
    asked = os.environ.get(COMPLETE)  # by the shell, as it completes
    if asked:
        from click.shell_completion import shell_complete

        return shell_complete(PROGRAM, {}, NAME, COMPLETE, asked)
    with PROGRAM.make_context(NAME, words) as context:
        return int(PROGRAM.invoke(context))


def _complain(line: str) -> int:
    log(f"abs-engine: error: {line}\n")
    return BAD_INPUT


def _open_what_is_closed() -> None:
    """Let the standard streams that the caller closed lead nowhere.

    Else the next file that is opened would take their number, and get what libraries complain.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            nowhere = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8")
            setattr(sys, name, nowhere)


def _is_lost() -> bool:
    """Whether stdout is what cannot be written, not another file or a process of our own."""
    try:
        print(flush=True)  # not empty, which an unbuffered stdout would not try to write
    except OSError:
        return True
    return False


def _let_go(stream: TextIO) -> None:
    """Send to nowhere what the interpreter still wants to write as it ends, with status 120."""
    with suppress(OSError, ValueError):  # a stream without a file has nothing to send
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextmanager
def _ended_as_interrupted() -> Iterator[None]:
    """End on SIGTERM and SIGHUP as on Ctrl-C, so that half-written output is removed."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in _ENDING}
    heeded = [number for number, did in before.items() if did is not signal.SIG_IGN]  # by nohup
    for number in heeded:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        for number in heeded:
            signal.signal(number, before[number])


def _stop(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
