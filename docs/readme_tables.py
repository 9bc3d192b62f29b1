"""Update the lists in README.md from tables in the code: ``python -m docs.readme_tables``."""

import re
from collections.abc import Iterator
from pathlib import Path

from bench.checks import checks_in
from bench.page import RESULTS, sections_of
from nmaptool.io.pictures.formats import READ_FORMATS
from nmaptool.options import BLEND_MODES, MATERIALS
from nmaptool.options.formats import NORMAL_MAP_FORMATS, RELIEF_FORMATS, WORKSPACE_FORMATS
from nmaptool.options.plates import MACHINES
from nmaptool.options.presets import DEPTH_PRESETS
from nmaptool.options.relief_presets import RELIEF_PRESETS

README = Path(__file__).parents[1] / "README.md"
_LIST = re.compile(r"(<!-- list: ([a-z ]+) -->\n)(.*?)(<!-- end of list -->)", re.DOTALL)

_HEADS = {
    "mode": "what it does",
    "--from": "what it reads",
    "--material": "what it is",
    "--preset": "what it makes",
    "--for": "for",
}


def lists() -> dict[str, str]:
    """The current lines of each list."""
    formats = {
        "normal maps": NORMAL_MAP_FORMATS.items(),
        "reliefs": RELIEF_FORMATS.items(),
        "workspaces": WORKSPACE_FORMATS.items(),
    }
    written = {name: _rows("file", ((e, f.description) for e, f in table)) for name, table in formats.items()}
    depths = _rows("--from", ((name, preset.description) for name, preset in DEPTH_PRESETS.items()))
    modes = ((name, mode.meaning) for name, mode in BLEND_MODES.items())
    pictures = "\n".join(
        ["| file | what is read |", "|---|---|", *(f"| {one.name} | {one.description} |" for one in READ_FORMATS)]
    )
    made = _rows("--preset", ((name, preset.description) for name, preset in RELIEF_PRESETS.items()))
    machines = _rows("--for", ((name, f"{one.description}: {one.listed}") for name, one in MACHINES.items()))
    return {
        "speed": speed(),
        "presets": made,
        "machines": machines,
        "blend modes": _rows("mode", modes),
        "materials": _rows("--material", ((name, material.description) for name, material in MATERIALS.items())),
        "depth pictures": depths,
        "pictures": pictures + "\n",
        **written,
    }


def speed() -> str:
    """The rows of `bench.quick` that have a rival, from the stored results."""
    quick = sections_of(RESULTS.read_text(encoding="utf-8")).get("quick", "")
    rivals = [check for check in checks_in(quick) if check.rival]
    rows = ["| task | time | rival | its time | ratio |", "|---|---:|---|---:|---:|"]
    for one in rivals:
        ours, its = (_milliseconds(text.split()[0]) for text in (one.found, one.its))
        rows.append(f"| {one.what} | {ours} | {one.rival} | {its} | {one.ratio} |")
    return "\n".join(rows) + "\n"


def _milliseconds(seconds: str) -> str:
    """Seconds as text, in ms with two or three digits.

    >>> _milliseconds("1.91"), _milliseconds("0.119"), _milliseconds("3.98e-05")
    ('1910 ms', '119 ms', '0.040 ms')
    """
    value = 1000 * float(seconds)
    return f"{value:.0f} ms" if value >= 10 else f"{value:.2g} ms" if value >= 0.1 else f"{value:.3f} ms"


def _rows(head: str, entries: Iterator[tuple[str, str]]) -> str:
    rows = [f"| {head} | {_HEADS.get(head, 'what it holds')} |", "|---|---|"]
    return "\n".join([*rows, *(f"| `{name}` | {text} |" for name, text in entries)]) + "\n"


def filled(text: str) -> str:
    """A page with its lists updated from the tables.

    Raises
    ------
    KeyError
        If the page has a list of unknown name.
    """
    now = lists()
    return _LIST.sub(lambda found: f"{found[1]}{now[found[2]]}{found[4]}", text)


def stale(text: str) -> list[str]:
    """The lists that are missing from a page or differ from the tables."""
    shown = {name: rows for _, name, rows, _ in _LIST.findall(text)}
    return [name for name, rows in lists().items() if shown.get(name) != rows]


def update() -> None:
    """Write the current lists to README.md."""
    README.write_text(filled(README.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    update()
