"""``nmap --install-completion``: completion of commands and flags when Tab is pressed."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.io.output.transaction import Outputs, Target
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Switch
from nmaptool_cli.command import command
from nmaptool_cli.run import Run

Shell = Literal["bash", "zsh", "fish"]
SHELLS: tuple[Shell, ...] = ("bash", "zsh", "fish")
NAMES = ("nmap", "nmaptool")
# lines of a zsh script for words of any value: '1:text' and '*--mask[text]:mask'
_ZSH_WITHOUT_ACTION = re.compile(
    r"""^(?P<start>\ +(?P<quote>['"])(?:[\d*]:(?:[^:\\]|\\.)*|\*?-.*\]:[\w-]+))(?P<end>(?P=quote)(?:\ \\)?)$""",
    re.MULTILINE,
)


@dataclass(frozen=True)
class CompletionOptions(Options, group="Outputs"):
    """The shell to complete in.

    Parameters
    ----------
    shell:
        Default: the shell that calls this command.
    overwrite:
        Replace existing files.
    """

    shell: Shell | None = option(None, choice_of(Shell))
    overwrite: bool = option(False, Switch())


@command(CompletionOptions)
def install_completion(run: Run, /) -> None:
    """Complete commands and flags with Tab, in bash, zsh or fish.

    Writes two files, one for nmap and one for nmaptool, to your folder of completions, and prints the next step. The
    shell's startup files are not changed.

    Example: nmap --install-completion --shell zsh
    """
    shell = run[CompletionOptions].shell or _detected()
    folder = completion_folder(shell)
    files = {name: folder / _file_name(shell, name) for name in NAMES}
    outputs: Outputs[dict[Path, str]] = Outputs(
        [Target(path, "a completion", (), _writer(path)) for path in files.values()],
        overwrite=run[CompletionOptions].overwrite,
        folders=[path for path in reversed((folder, *folder.parents)) if not path.exists()],
    )
    run.begin(outputs)
    scripts = {path: completion_script(shell, name) for name, path in files.items()}
    run.finish(outputs, scripts, run.header(shell=shell))
    run.say(next_step(shell, folder))
    run.speak()


def completion_script(shell: Shell, name: str) -> str:
    """The script with which the shell completes the command of this name.

    Where the parser's script offers nothing because any word is valid, the shell completes file names, since inputs are
    files; the shell also quotes them.
    """
    from nmaptool_cli.main import app

    script = app.generate_completion(prog_name=name, shell=shell)
    match shell:
        case "bash":
            script = script.replace('COMPREPLY=( $(compgen -f -- "${cur}") )', "COMPREPLY=()")
            return script.replace(f"complete -F _{name} ", f"complete -o bashdefault -o default -F _{name} ")
        case "zsh":
            return _ZSH_WITHOUT_ACTION.sub(r"\g<start>:_files\g<end>", script)
    return script


def completion_folder(shell: Shell) -> Path:
    """The folder of the user's completions; zsh searches it only once `next_step` is done."""
    home = Path.home()
    match shell:
        case "bash":
            own = os.environ.get("BASH_COMPLETION_USER_DIR", "").partition(os.pathsep)[0]
            data = os.environ.get("XDG_DATA_HOME") or home / ".local" / "share"
            return Path(own or Path(data) / "bash-completion") / "completions"
        case "zsh":
            return home / ".zsh" / "completions"
        case "fish":
            return Path(os.environ.get("XDG_CONFIG_HOME") or home / ".config") / "fish" / "completions"


def next_step(shell: Shell, folder: Path) -> str:
    """What the user must do to activate completion."""
    match shell:
        case "bash":
            line = "; ".join(f"source {shlex.quote(str(folder / name))}" for name in NAMES)
            return f"  next: open a new terminal; if Tab does not complete there, add this line to ~/.bashrc: {line}"
        case "zsh":
            line = f"fpath=({shlex.quote(str(folder))} $fpath); autoload -Uz compinit; compinit"
            return f"  next: add this line at the top of ~/.zshrc and open a new terminal: {line}"
        case "fish":
            return "  next: open a new terminal"


def _file_name(shell: Shell, name: str) -> str:
    # zsh calls the function named after the file; _nmap is its own function for the network scanner
    return {"bash": name, "zsh": f"_cyclopts_{name}", "fish": f"{name}.fish"}[shell]


def _writer(place: Path) -> Callable[[Mapping[Path, str], Path], object]:
    return lambda scripts, path: path.write_text(scripts[place], encoding="utf-8", newline="\n")


def _detected() -> Shell:
    from cyclopts.completion import ShellDetectionError, detect_shell

    try:
        found: str = detect_shell()
    except ShellDetectionError:
        found = ""
    for shell in SHELLS:
        if found == shell:
            return shell
    other = f"completion is not available for {found}" if found else "cannot tell which shell this is"
    raise UsageError(f"{other}; name one of {', '.join(SHELLS)}, such as --shell bash")
