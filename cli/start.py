"""Entry point of the console scripts: Ctrl-C during loading also gives only one line."""

from __future__ import annotations

import sys


def run() -> None:
    """Load the command line and run it."""
    try:
        from nmaptool_cli.main import run
    except KeyboardInterrupt:
        print("nmap: error: interrupted; nothing was written", file=sys.stderr)
        sys.exit(130)
    run()
