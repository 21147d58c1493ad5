"""`python -m abs_engine` is the command `abs-engine`."""

from __future__ import annotations

import signal
import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

INTERRUPTED = 130  # as of a shell that was interrupted
_SOON = 0.01  # seconds


def run() -> int:
    """Run the command; an interrupt while it is loaded is an interrupt like any other."""
    sys.unraisablehook = _ask_again
    try:
        from abs_engine.cli import main

        return main()
    except KeyboardInterrupt:
        sys.stderr.write("abs-engine: interrupted\n")
        return INTERRUPTED


def _ask_again(dropped: UnraisableHookArgs) -> None:
    """Interrupt once more if an interrupt came in a callback, whose errors Python drops.

    Such as that by which each import lets its lock go.
    """
    if not issubclass(dropped.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(dropped)
        return
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # then it was another
    again = signal.SIGTERM if ignored else signal.SIGINT
    to = threading.main_thread().ident
    later = threading.Timer(_SOON, signal.pthread_kill, (to, again))  # once the callback is over
    later.daemon = True
    later.start()


if __name__ == "__main__":
    sys.exit(run())
