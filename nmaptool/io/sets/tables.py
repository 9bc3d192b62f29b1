"""Read tables of jobs: TOML or CSV."""

from __future__ import annotations

import csv
import io
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.mentions import written_name
from nmaptool.io.opening import read_head
from nmaptool.types.batch import BatchJob

TABLE_ENDINGS = (".toml", ".csv")
_MOST_BYTES = 64_000_000
_VALUES = (str, bool, int, float)
_SWITCHES = {"true": True, "yes": True, "false": False, "no": False}


def is_table(name: str) -> bool:
    """Whether a file is a table of jobs, by its extension."""
    return name.lower().endswith(TABLE_ENDINGS)


def read_jobs(path: str | Path) -> list[BatchJob]:
    """Read a table of jobs.

    Parameters
    ----------
    path : str or Path
        A TOML file with tables ``[[job]]``, and ``[defaults]`` for all of them; or a CSV file with a line of column
        names and a line for each job. File names in it are relative to its folder.

    Raises
    ------
    InputError
        If it cannot be read, holds no job, or a job has no command or no input.
    LimitError
        If it is larger than 64 MB.
    """
    path = Path(path)
    if not is_table(path.name):
        raise InputError(f"{path}: is not a table of jobs; accepted are {' and '.join(TABLE_ENDINGS)}")
    text = _text(path)
    rows = _toml_rows(path, text) if path.suffix.lower() == ".toml" else _csv_rows(path, text)
    jobs = [job_of(row, path.parent, f"{path}, {place}") for place, row in rows]
    if not jobs:
        raise InputError(f"{path}: holds no job; add one, such as [[job]] with command, inputs and output")
    return jobs


def job_of(values: Mapping[str, Any], folder: Path, place: str) -> BatchJob:
    """Return the job of a row.

    Parameters
    ----------
    values : mapping
        ``command``, ``inputs`` (or ``input``), and options by the names of their flags, with - or _.
    folder : Path
    place : str
        Where it is written, for messages.

    Raises
    ------
    InputError
        If there is no command or input, or a value is of a wrong type.
    """
    options = dict(values)
    command = options.pop("command", None)
    if not isinstance(command, str) or not command.strip():
        raise InputError(f'{place}: command is missing; name one, such as command = "relief"')
    if "input" in options and "inputs" in options:
        raise InputError(f"{place}: input and inputs are both given; leave one of them out")
    inputs = options.pop("inputs", options.pop("input", None))
    names = [inputs] if isinstance(inputs, str | Path) else inputs
    if not isinstance(names, list | tuple) or not names or not all(_is_name(name) for name in names):
        raise InputError(f'{place}: inputs must be a file name, a pattern or a list of them, such as "maps/*.png"')
    found: dict[str, Any] = {}
    for key, value in options.items():
        name = written_name(str(key)).replace("_", "-")
        if name in found:
            raise InputError(f"{place}: {name} is given twice; leave one of them out")
        found[name] = _checked(value, name, place)
    return BatchJob(" ".join(command.split()), tuple(map(str, names)), found, folder=folder, place=place)


def _is_name(value: Any) -> bool:
    return isinstance(value, str | Path) and str(value) != ""


def _checked(value: Any, name: str, place: str) -> Any:
    """Return the value of an option if a flag can have it."""
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, list | tuple):
        return [_checked(each, name, place) for each in value]
    if not isinstance(value, _VALUES):
        raise InputError(f"{place}: {name} must be text, a number, true, false or a list of them, found {value!r}")
    return value


def _text(path: Path) -> str:
    _, size = read_head(path, 1, "a table of jobs", "save it as a file")
    if size > _MOST_BYTES:
        raise LimitError(
            f"{path}: has {size / 1e6:.0f} MB, more than the limit of {_MOST_BYTES / 1e6:.0f} MB; split it"
        )
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def _toml_rows(path: Path, text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    try:
        values = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: is not valid TOML ({error})") from None
    for key in values:
        if key not in ("job", "defaults"):
            raise InputError(f"{path}: has no table {key!r}; use [[job]] for each job and [defaults] for all of them")
    defaults, rows = values.get("defaults", {}), values.get("job", [])
    if not isinstance(defaults, dict):
        raise InputError(f"{path}: defaults must be a table, [defaults]")
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{path}: job must be tables with double brackets, [[job]]")
    common = _named(defaults)
    for number, row in enumerate(rows, start=1):
        own = _named(row)
        if {"input", "inputs"} & set(own):
            shared = {key: value for key, value in common.items() if key not in ("input", "inputs")}
        else:
            shared = common
        yield f"job {number}", shared | own


def _named(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with - for _ in its keys."""
    return {key.replace("_", "-"): value for key, value in row.items()}


def _csv_rows(path: Path, text: str) -> Iterator[tuple[str, dict[str, Any]]]:
    lines = csv.reader(io.StringIO(text, newline=""), delimiter=_delimiter(text), strict=True)
    try:
        header = [cell.strip().removeprefix("--") for cell in next(lines, [])]
        if "command" not in header:
            raise InputError(f"{path}: the first line must name the columns, command and inputs among them")
        for cells in lines:
            if not any(cell.strip() for cell in cells):
                continue
            place = f"line {lines.line_num}"
            if len(cells) > len(header):
                raise InputError(
                    f"{path}, {place}: has {len(cells)} cells for {len(header)} columns; put quotes around text "
                    "with commas"
                )
            yield place, _row(header, cells, f"{path}, {place}")
    except csv.Error as error:
        raise InputError(f"{path}, line {lines.line_num}: is not valid CSV ({error})") from None


def _delimiter(text: str) -> str:
    """Return the delimiter: a semicolon where spreadsheets write it, since the comma is in their numbers."""
    header = text.partition("\n")[0]
    return max(",;\t", key=header.count)


def _row(header: list[str], cells: list[str], place: str) -> dict[str, Any]:
    """Return a row without its empty cells; columns of the same name become a list."""
    found: dict[str, Any] = {}
    for name, cell in zip(header, cells, strict=False):
        value = _SWITCHES.get(cell.strip().lower(), cell.strip())
        if value == "":
            continue
        if not name:
            raise InputError(f"{place}: {cell.strip()!r} stands in a column without a name")
        found[name] = value if name not in found else [*_several(found[name]), value]
    return found


def _several(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]
