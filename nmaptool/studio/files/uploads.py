"""Receives the files that the user drops on the window."""

from __future__ import annotations

from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from nmaptool.core.errors import LimitError, NmaptoolError, OutputError, reason_of
from nmaptool.studio.background import error_message
from nmaptool.studio.files import drops
from nmaptool.studio.room import Room

_LARGEST_BYTES = 4_000_000_000
_MOST_FILES = 1000


async def receive(room: Room, request: Request) -> Response:
    """Keep the body of a request as a file; answer with its name in the store and what it holds."""
    try:
        return JSONResponse(await _received(room, request))
    except NmaptoolError as error:
        return JSONResponse(error_message(error, room.store), 400)


async def _received(room: Room, request: Request) -> dict[str, str]:
    name = request.path_params["name"]
    if len(list(room.store.folder.iterdir())) >= _MOST_FILES:
        raise LimitError(f"{name}: {_MOST_FILES} files were dropped already; start the studio again")
    path = room.store.place(name)
    part = path.with_name(f"{path.name}.part")
    count = 0
    try:
        with part.open("wb") as file:
            async for piece in request.stream():
                count += len(piece)
                if count > _LARGEST_BYTES:
                    raise LimitError(
                        f"{name}: is larger than {_LARGEST_BYTES / 1e9:g} GB, the limit for a dropped file"
                    )
                file.write(piece)
        part.rename(path)
    except OSError as error:
        raise OutputError(f"{name}: cannot be kept ({reason_of(error)})") from None
    except ClientDisconnect:
        raise OutputError(f"{name}: the page closed before the file had come") from None
    finally:
        part.unlink(missing_ok=True)
    try:
        kind = await run_in_threadpool(drops.kind_of, path)
    except NmaptoolError as error:
        path.unlink(missing_ok=True)
        raise type(error)(str(error).replace(str(path), name)) from None
    return {"file": path.name, "kind": kind}
