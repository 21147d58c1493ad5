"""`python -m abs_engine` is the command `abs-engine`."""

import sys

INTERRUPTED = 130  # as of a shell that was interrupted


def run() -> int:
    """Run the command; an interrupt while it is loaded is an interrupt like any other."""
    try:
        from abs_engine.cli import main

        return main()
    except KeyboardInterrupt:
        sys.stderr.write("abs-engine: interrupted\n")
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(run())
