"""Commands: functions of a run, whose flags are the fields of options classes.

``@command(BakeOptions, FilterOptions)`` turns ``bake(run, mesh)`` into a function that the parser calls with the
arguments of the command line. Flags are not defined here: `nmaptool_cli.flags` makes them from the classes.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any, get_type_hints

from nmaptool.core.text import listed
from nmaptool.io.meshes.headers import NAMES
from nmaptool.io.pictures.formats import format_names
from nmaptool.options.fields import Options, kind_of, read_values
from nmaptool.options.kinds import Count, Kind
from nmaptool_cli.flags import flags_of
from nmaptool_cli.mentions import flag_of
from nmaptool_cli.per_input import PerInput
from nmaptool_cli.run import Run, RunOptions

Function = Callable[..., "int | None"]


class Command:
    """A function of a run and its file names, and the options classes that define its flags.

    Parameters
    ----------
    function : callable
        ``function(run, *files)``; its docstring is the command's help.
    classes : tuple of type of Options
    per_input : PerInput or None
        Flags that are given once for all inputs or once for each.
    completed : tuple of type of Options
        Those of the classes whose flags change the values of a preset or recipe: they need not make sense alone.
    """

    def __init__(
        self,
        function: Function,
        classes: tuple[type[Options], ...],
        per_input: PerInput | None,
        completed: tuple[type[Options], ...] = (),
    ) -> None:
        self.function = function
        self.classes = (*classes, RunOptions)
        self.per_input = per_input
        self.completed = completed

    def __call__(self, *files: Any, **words: Any) -> int | None:
        """Run the command with the parsed arguments."""
        given, named = self.read(words)
        return self.function(Run(given, named, words, self.per_input), *files)

    def read(self, words: dict[str, Any]) -> tuple[dict[type[Options], Options], dict[type[Options], dict[str, Any]]]:
        """Take the options out of the parsed flags; return those by class, and the ones that are given.

        Raises
        ------
        UsageError
            If an option is not accepted.
        """
        given: dict[type[Options], Options] = {}
        named: dict[type[Options], dict[str, Any]] = {}
        for options in self.classes:
            names = [field.name for field in dataclasses.fields(options)]
            named[options] = read_values(options, {name: words.pop(name) for name in names if name in words})
            if options not in self.completed:
                given[options] = options(**named[options])
        return given, named

    @property
    def option_names(self) -> set[str]:
        """Names of the options that flags set."""
        return {field.name for options in self.classes for field in dataclasses.fields(options)}

    def parameters(self) -> Iterator[inspect.Parameter]:
        """File names first, then every flag."""
        hints = get_type_hints(self.function, include_extras=True)
        for parameter in list(inspect.signature(self.function).parameters.values())[1:]:
            yield parameter.replace(annotation=hints[parameter.name])
        if self.per_input is not None:
            yield from self.per_input.flags()
        for options in self.classes:
            yield from flags_of(options)

    @property
    def help(self) -> str:
        """The function's docstring, with the formats that can currently be read."""
        named = {"pictures": format_names(), "meshes": listed(NAMES.values())}
        return re.sub(r"{(pictures|meshes)}", lambda found: named[found[1]], self.function.__doc__ or "")

    @property
    def kinds(self) -> dict[str, Kind]:
        """The kind of each flag."""
        found = {} if self.per_input is None else self.per_input.kinds()
        for options in self.classes:
            found |= {field.name: kind for field in dataclasses.fields(options) if (kind := kind_of(field)) is not None}
        return {flag_of(name): kind for name, kind in found.items()}

    @property
    def signed(self) -> frozenset[str]:
        """Flags whose values may begin with a minus sign."""
        return frozenset(flag for flag, kind in self.kinds.items() if kind.signed)

    @property
    def whole(self) -> frozenset[str]:
        """Flags that take whole numbers."""
        return frozenset(flag for flag, kind in self.kinds.items() if isinstance(kind, Count))


def command(
    *classes: type[Options], per_input: PerInput | None = None, completed: tuple[type[Options], ...] = ()
) -> Callable[[Function], Any]:
    """Make a command with the flags of these classes from a function of a `Run` and its file names.

    The result is a plain function, as the parser requires; `command_of` returns its `Command`.
    """

    def make(function: Function) -> Any:
        made = Command(function, classes, per_input, completed)

        @functools.wraps(function)
        def call(*files: Any, **words: Any) -> int | None:
            return made(*files, **words)

        del call.__wrapped__  # the parser would use its signature
        call.command = made  # type: ignore[attr-defined]
        command_of(call)
        return call

    return make


def command_of(call: Any) -> Command:
    """The command behind a function; updates its help and flags from the current tables."""
    made: Command = call.command
    parameters = list(made.parameters())
    call.__signature__ = inspect.Signature(parameters)
    call.__doc__ = made.help
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return made
