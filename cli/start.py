"""Where the console scripts begin: Ctrl-C while the commands load ends in one line, too."""

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
