"""`python -m abs_engine` is the command `abs-engine`."""

import sys

from abs_engine.cli import main

if __name__ == "__main__":
    sys.exit(main())
