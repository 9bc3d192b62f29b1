"""Serves the studio on this machine."""

from __future__ import annotations

import secrets
import socket
import threading
from collections.abc import Sequence
from pathlib import Path

import uvicorn
from platformdirs import user_config_path, user_state_path

from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.studio.app import application
from nmaptool.studio.document import Document
from nmaptool.studio.engine import Engine
from nmaptool.studio.files.store import Store
from nmaptool.studio.forms.presets import Presets
from nmaptool.studio.room import Room

LOOPBACK = "127.0.0.1"


class Studio:
    """A server for one document, for this machine alone unless another address is given.

    Parameters
    ----------
    document : Document
    port : int
        0 chooses a free one.
    host : str
        The address to listen on.
    root : Path, optional
        Folder for what is dropped and painted, and for the user's presets. Default: one in the user's folder for the
        state of programs, and another in that for settings.
    meshes : sequence of Path
        Mesh files to open; the first page to come shows their camera panel.

    Raises
    ------
    UsageError
        If ``host`` stands for every address of this machine: pages of other names could then reach it.
    OutputError
        If the address or the port cannot be used.
    """

    def __init__(
        self,
        document: Document,
        port: int = 0,
        *,
        host: str = LOOPBACK,
        root: Path | None = None,
        meshes: Sequence[Path] = (),
    ) -> None:
        if host in ("", "0.0.0.0", "::"):
            raise UsageError(f"`host={host!r}`: stands for every address; give one, such as 192.168.1.5")
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((host, port))
            self._socket.listen()  # a browser may come before the server is up
        except OSError as error:
            self._socket.close()
            if host != LOOPBACK:
                place, flags = f"{host}, port {port},", "`host` and `port`"
            else:
                place, flags = f"port {port}", "`port`"
            raise OutputError(f"{place} cannot be used ({reason_of(error)}); choose another one with {flags}") from None
        self.port: int = self._socket.getsockname()[1]
        presets = user_config_path("nmaptool", appauthor=False) if root is None else root
        root = user_state_path("nmaptool", appauthor=False) / "studio" if root is None else root
        self._room = Room(document, Store(root, (host, self.port)), Presets(presets / "presets"))
        token = secrets.token_urlsafe(24)
        names = (host, "localhost") if host == LOOPBACK else (host,)
        hosts = tuple(f"{name}:{self.port}" for name in names)
        self.address = f"http://{host}:{self.port}/?token={token}"
        for mesh in meshes:
            self._room.sources.welcome(mesh)
        config = uvicorn.Config(
            application(self._room, token, hosts),
            log_level="warning",
            access_log=False,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=1 << 20,
            ws_per_message_deflate=False,  # packing heights takes longer than sending them to this machine
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)

    def run(self) -> None:
        """Serve until Ctrl-C or `stop`; Ctrl-C ends it like `stop`."""
        # in a thread, because the server would otherwise take over Ctrl-C
        thread = threading.Thread(target=self._server.run, kwargs={"sockets": [self._socket]}, name="studio server")
        thread.start()
        try:
            while thread.is_alive():
                thread.join(0.2)
        except KeyboardInterrupt:
            pass
        finally:
            self.stop()
            thread.join()
            self._socket.close()
            if not self.has_unsaved:
                self._room.store.remove()

    @property
    def is_started(self) -> bool:
        """Whether it answers requests."""
        return self._server.started

    @property
    def engine(self) -> Engine | None:
        """The maps and sessions of the document; None before they were read."""
        return self._room.worker.engine_of(self._room.now)

    @property
    def has_unsaved(self) -> bool:
        """Whether there is work that was not saved; it is kept, and offered when the studio starts again."""
        return self._room.has_unsaved

    def stop(self) -> None:
        """End `run`, from another thread."""
        self._server.should_exit = True
