"""A benchmark as a program: its command line, the lines on the machine, and its section of results.md."""

from __future__ import annotations

import argparse
from typing import Any

from bench.table import Neighborhood, write_section


class Report:
    """What a benchmark prints and, with --write, keeps.

    Parameters
    ----------
    name : str
        Of the module in ``bench``, and of the section.
    description : str or None
        For --help.
    """

    def __init__(self, name: str, description: str | None) -> None:
        self._name = name
        self._parser = argparse.ArgumentParser(prog=f"python -m bench.{name}", description=description)
        self._keep = False

    def argument(self, name: str, **how: Any) -> None:
        """Add one to the command line, as `argparse.ArgumentParser.add_argument` does."""
        self._parser.add_argument(name, **how)

    def begin(self) -> argparse.Namespace:
        """Read the command line and look at the machine; nothing is measured before."""
        self._parser.add_argument("--write", action="store_true", help="keep the results in results.md")
        options = self._parser.parse_args()
        self._keep = options.write
        self._surroundings = Neighborhood(f"bench.{self._name}")
        return options

    def end(self, *parts: str) -> None:
        """Print the lines on the machine, then all parts, and keep them."""
        body = "\n\n".join([self.surroundings(), *parts])
        print(body)
        self.write(body)

    def surroundings(self) -> str:
        """Markdown lines on the run so far."""
        return self._surroundings.describe()

    def write(self, body: str) -> None:
        """Keep a section that is already printed, where --write says so."""
        if self._keep:
            write_section(self._name, body)


class MeshReport(Report):
    """That of a benchmark on meshes: made spheres of several sizes, or files."""

    def __init__(self, name: str, description: str | None) -> None:
        super().__init__(name, description)
        self.argument("--mesh", action="append", help="a mesh file instead of the spheres; repeatable")
        self.argument("--repeat", type=int, default=2, help="runs of each, the best counts (default 2)")
