"""``nmap studio``."""

from __future__ import annotations

import contextlib
import importlib.util
import webbrowser
from dataclasses import dataclass, replace
from pathlib import Path

from nmaptool.core.errors import InputError, UsageError
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Count, Switch, Text
from nmaptool_cli.command import command
from nmaptool_cli.run import Run
from nmaptool_cli.streams import refuse_stream

_PACKAGES = ("platformdirs", "starlette", "uvicorn", "websockets")


@dataclass(frozen=True)
class StudioOptions(Options, group="Studio"):
    """Where the studio is served.

    Parameters
    ----------
    port:
        Port on this machine, such as 8000. Default: a free one.
    host:
        Address of this machine to serve on, such as 192.168.1.5, to open the studio on another machine. Whoever has the
        printed address with its token can then use it, and the connection is not encrypted. Default: 127.0.0.1, which
        only this machine reaches.
    no_browser:
        Only print the address; do not open it in the browser.
    """

    port: int | None = option(None, Count("8000", 1, 65535))
    host: str | None = option(None, Text("192.168.1.5"))
    no_browser: bool = option(False, Switch())


@command(StudioOptions)
def studio(run: Run, /, *files: str) -> None:
    """Shape a relief in the browser, under a light that you move.

    The studio runs on your own machine and answers to nobody else, unless --host says so. Its document is a recipe,
    which nmap relief turns into the same relief. Ctrl-C ends it.

    Example: nmap studio samples/medal_original.png

    Parameters
    ----------
    files:
        A recipe (.toml), or one or more normal maps as layers: {pictures}. Meshes open the camera: {meshes}.
    """
    lacking = [name for name in _PACKAGES if importlib.util.find_spec(name) is None]
    if lacking:
        raise UsageError(
            f'the studio needs {", ".join(lacking)}; install it with: pip install "nmaptool-relief[studio]"'
        )
    refuse_stream("the studio opens files", *files)
    from nmaptool.studio.document import opened
    from nmaptool.studio.files.drops import is_mesh
    from nmaptool.studio.server import LOOPBACK, Studio

    given = run[StudioOptions]
    meshes = [Path(name).absolute() for name in files if is_mesh(name)]
    document = opened([name for name in files if not is_mesh(name)])
    for mesh in meshes:
        if not mesh.is_file():
            raise InputError(f"{mesh.name}: no such file")
    if meshes and not document.layers:
        document = replace(document, folder=meshes[0].parent)
    served = Studio(document, given.port or 0, host=given.host or LOOPBACK, meshes=meshes)
    run.say(f"nmap studio: {served.address}", "  Ctrl-C ends it")
    run.speak()
    if not given.no_browser:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(served.address)
    served.run()
    if served.has_unsaved:
        run.say("the changes that were not saved are kept; nmap studio offers them at its next start")
        run.speak()
