"""Entry point of the console scripts: Ctrl-C during loading also gives only one line."""

from __future__ import annotations

import gc
import sys

# new objects between two searches for cycles; by default 700, so that imports would spend a tenth of their time on it
_NEW_OBJECTS = 10_000


def run() -> None:
    """Load the command line and run it."""
    gc.disable()  # what is loaded stays
    try:
        from nmaptool_cli.main import run
    except KeyboardInterrupt:
        print("nmap: error: interrupted; nothing was written", file=sys.stderr)
        sys.exit(130)
    gc.freeze()
    gc.set_threshold(_NEW_OBJECTS)
    gc.enable()
    run()
