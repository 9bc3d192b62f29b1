"""Common parts of benchmarks: command line, description of the machine, section of results.md."""

from __future__ import annotations

import argparse
from typing import Any

from bench.page import write_section
from bench.table import Neighborhood


class Report:
    """The printed and, with --write, stored output of a benchmark.

    Parameters
    ----------
    name : str
        Name of the module in ``bench`` and of the section.
    description : str or None
        Text for --help.
    """

    def __init__(self, name: str, description: str | None) -> None:
        self._name = name
        self._parser = argparse.ArgumentParser(prog=f"python -m bench.{name}", description=description)
        self._keep = False

    def argument(self, name: str, **how: Any) -> None:
        """Add an argument to the command line, as `argparse.ArgumentParser.add_argument` does."""
        self._parser.add_argument(name, **how)

    def begin(self) -> argparse.Namespace:
        """Read the command line and describe the machine; call this before any measurement."""
        self._parser.add_argument("--write", action="store_true", help="store the results in results.md")
        options = self._parser.parse_args()
        self._keep = options.write
        self._surroundings = Neighborhood(f"bench.{self._name}")
        return options

    def end(self, *parts: str) -> None:
        """Print the description of the machine, then all parts, and store them."""
        body = "\n\n".join([self.surroundings(), *parts])
        print(body)
        self.write(body)

    def surroundings(self) -> str:
        """Markdown lines that describe the run so far."""
        return self._surroundings.describe()

    def write(self, body: str) -> None:
        """With --write, store a section that is already printed."""
        if self._keep:
            write_section(self._name, body)


class MeshReport(Report):
    """Report of a benchmark on meshes: generated spheres of several sizes, or files."""

    def __init__(self, name: str, description: str | None) -> None:
        super().__init__(name, description)
        self.argument("--mesh", action="append", help="a mesh file instead of the spheres; repeatable")
        self.argument("--repeat", type=int, default=2, help="number of runs; the shortest time counts (default 2)")
