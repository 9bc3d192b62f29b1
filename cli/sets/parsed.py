"""The commands that a batch may run, and what their flags say about files."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

from cyclopts.exceptions import CycloptsError

from nmaptool.core.errors import NmaptoolError, UsageError
from nmaptool.core.mentions import written_name
from nmaptool.core.text import listed
from nmaptool.options.fields import Options
from nmaptool_cli.arguments import prepared
from nmaptool_cli.command import Command, command_of
from nmaptool_cli.guard import usage
from nmaptool_cli.mentions import flag_of
from nmaptool_cli.run import RunOptions

# they run for hours or until they are stopped, or are batches themselves
_NOT_IN_SETS = ("batch", "studio", "train", "--install-completion")
# options that do not change what is written
_WITHOUT_EFFECT = {"overwrite", "memory_limit", *(field.name for field in dataclasses.fields(RunOptions))}


def command_names() -> list[str]:
    """The commands that a batch may run, such as "relief" and "compose convert"."""
    from nmaptool_cli.main import app

    return list(_names(app, ""))


def _names(app: Any, before: str) -> Iterator[str]:
    for name in app:
        if name.startswith("-") or name in _NOT_IN_SETS:
            continue
        inner = app[name]
        if inner.default_command is None:
            yield from _names(inner, f"{before}{name} ")
        else:
            yield before + name


def named_command(name: str) -> Command:
    """The command of this name.

    Raises
    ------
    UsageError
        If a batch cannot run it.
    """
    command: Command = _function(name).command
    return command


@functools.cache
def _function(name: str) -> Any:
    """The function that the parser calls for the command of this name."""
    from nmaptool_cli.main import app

    words = name.split()
    chain, apps, _ = app.parse_commands(words)
    found = apps[-1].default_command
    if list(chain) != words or name in _NOT_IN_SETS or not hasattr(found, "command"):
        raise UsageError(f"{name}: is not a command for a batch; use {listed(command_names())}")
    return found


@dataclass(frozen=True)
class Parsed:
    """The parsed words of a command.

    Parameters
    ----------
    values : dict
        What is given, by name: the files first.
    positional : frozenset of str
        Names of the files that have no flag.
    outputs : frozenset of str
        Names of files or folders to write.
    """

    values: dict[str, Any]
    positional: frozenset[str]
    outputs: frozenset[str]

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The files that have no flag."""
        given = [value for name, value in self.values.items() if name in self.positional]
        return tuple(each for value in given for each in _each(value))

    @property
    def flags(self) -> dict[str, Any]:
        """The values of the flags that are given, by name."""
        return {name: value for name, value in self.values.items() if name not in self.positional}

    def texts(self, *, outputs: bool) -> list[str]:
        """The texts among the outputs, or among all other values."""
        chosen = [value for name, value in self.values.items() if (name in self.outputs) == outputs]
        return [str(each) for value in chosen for each in _each(value) if isinstance(each, str | Path)]

    def lasting(self) -> dict[str, list[str]]:
        """The values that change what is written, as texts, in an order that does not depend on that of the flags."""
        kept = {name: value for name, value in self.values.items() if name not in _WITHOUT_EFFECT}
        return {name: [str(each) for each in _each(kept[name])] for name in sorted(kept)}

    def of(self, source: str, fill: Callable[[str], str]) -> Parsed:
        """The same with ``fill(text)`` for every text, and an input as the first file."""
        values = {name: _filled(value, fill) for name, value in self.values.items()}
        first = next(iter(values))
        values[first] = source if isinstance(values[first], str) else (source, *values[first][1:])
        return dataclasses.replace(self, values=values)


def parse(name: str, words: Sequence[str]) -> Parsed:
    """Parse the words of a command and check its options, without running it.

    Raises
    ------
    UsageError
        If the command line refuses them.
    """
    from nmaptool_cli.main import app

    command = command_of(_function(name))
    try:
        ready = prepared([*name.split(), *words], command)
        _, bound, _ = app.parse_args(ready, exit_on_error=False, print_error=False)
        command.read({key: value for key, value in bound.arguments.items() if key in command.option_names})
    except CycloptsError as error:
        if isinstance(error.__cause__, NmaptoolError):
            raise error.__cause__ from None
        raise UsageError(f"{usage(error)} (see nmap {name} --help)") from None
    files = [each.name for each in command.parameters() if each.kind is not each.KEYWORD_ONLY]
    return Parsed(dict(bound.arguments), frozenset(files), frozenset(_outputs(command)))


def _outputs(command: Command) -> Iterator[str]:
    """Names of the arguments that name outputs: paths in the group of outputs, and paths without a flag."""
    options: type[Options]
    for options in command.classes:
        if options.group == "Outputs":
            hints = get_type_hints(options)
            yield from (field.name for field in dataclasses.fields(options) if "Path" in str(hints[field.name]))
    for parameter in command.parameters():
        if parameter.kind is parameter.POSITIONAL_ONLY and "Path" in str(parameter.annotation):
            yield parameter.name


def takes_several(name: str) -> bool:
    """Whether one run needs a second input, such as the detail for a base or the layers for a background."""
    files = [each for each in named_command(name).parameters() if each.kind is not each.KEYWORD_ONLY]
    return any(each.default is inspect.Parameter.empty for each in files[1:])


def split_words(name: str, words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split the words of a command into its inputs and its flags with their values."""
    command = named_command(name)
    alone = {flag for flag, takes in _flags(command) if not takes}
    inputs: list[str] = []
    flags: list[str] = []
    waiting = False
    for word in words:
        is_flag = word.startswith("-") and len(word) > 1 and not waiting
        if is_flag or waiting:
            flags.append(word)
            waiting = is_flag and "=" not in word and word not in alone
        else:
            inputs.append(word)
    return inputs, flags


def flag_words(name: str, options: Mapping[str, Any]) -> list[str]:
    """The options of a row of a table as words of the command line; false and an empty list stand for the default.

    Raises
    ------
    UsageError
        If the command has no such option, or a switch gets another value than true or false.
    """
    takes_value = {flag: takes for flag, takes in _flags(named_command(name)) if flag.startswith("--")}
    found: list[str] = []
    for key, value in options.items():
        given = [each for each in _each(value) if each is not False]  # false is the default of every switch
        flag = flag_of(key)
        if given and flag not in takes_value:
            known = listed(sorted(each.removeprefix("--") for each in takes_value))
            raise UsageError(f"{written_name(key)}: is not an option of nmap {name}; use one of {known}")
        if any(isinstance(each, bool) == takes_value[flag] for each in given):
            wanted = "a value, not true or false" if takes_value[flag] else "true or false"
            raise UsageError(f"{written_name(key)}: needs {wanted}")
        found += [flag if each is True else f"{flag}={each}" for each in given]
    return found


def _flags(command: Command) -> Iterator[tuple[str, bool]]:
    """Every flag of a command with its short form, and whether it takes a value."""
    for parameter in command.parameters():
        if parameter.kind is parameter.KEYWORD_ONLY:
            for shown in parameter.annotation.__metadata__:
                for flag in [shown.name] if isinstance(shown.name, str) else shown.name or ():
                    yield flag, parameter.annotation.__origin__ is not bool


def _each(value: Any) -> Iterable[Any]:
    return value if isinstance(value, list | tuple) else (value,)


def _filled(value: Any, fill: Callable[[str], str]) -> Any:
    if isinstance(value, list | tuple):
        return tuple(_filled(each, fill) for each in value)
    if isinstance(value, Path):
        return Path(fill(str(value)))
    return fill(value) if isinstance(value, str) else value
