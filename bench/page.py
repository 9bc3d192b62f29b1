"""results.md: a section for each benchmark, and all their figures with goals in one table."""

from __future__ import annotations

import re
from pathlib import Path

from bench.checks import HEADER, MEANING, checks_in, rows_of
from bench.table import table

RESULTS = Path(__file__).with_name("results.md")
SUMMARY = "All figures with goals"
_TITLE = (
    "# Measured speed and memory\n\nMade by `python -m bench --write`, which runs every benchmark; "
    "`python -m bench.solver --write` and the like renew one section\nand the table of all figures."
)


def sections_of(text: str) -> dict[str, str]:
    """The sections of a page without the summary, by title."""
    found = dict(part.split("\n", 1) for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:])
    return {title: body.strip() for title, body in found.items() if title != SUMMARY}


def summary(sections: dict[str, str]) -> str:
    """The check lines of all sections as one table."""
    rows = [
        [f"{title}: {row[0]}", *row[1:]] for title in sorted(sections) for row in rows_of(checks_in(sections[title]))
    ]
    return f"{MEANING}\n\n{table(HEADER, rows)}"


def page_of(sections: dict[str, str]) -> str:
    """The whole page."""
    parts = [_TITLE, f"## {SUMMARY}\n\n{summary(sections)}"]
    parts += [f"## {title}\n\n{sections[title]}" for title in sorted(sections)]
    return "\n\n".join(parts) + "\n"


def write_section(name: str, body: str) -> None:
    """Replace the section of the same name in results.md and update the summary; the other sections stay."""
    sections = sections_of(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    RESULTS.write_text(page_of(sections | {name: body.strip()}), encoding="utf-8")
