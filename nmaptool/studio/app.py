"""The web application of the studio."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Callable
from typing import Any

from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from nmaptool.core.errors import NmaptoolError
from nmaptool.studio.background import error_message
from nmaptool.studio.files.uploads import receive
from nmaptool.studio.guard import Guard
from nmaptool.studio.meshes.routes import mesh_routes
from nmaptool.studio.overlays import overlay
from nmaptool.studio.page_files import page_routes
from nmaptool.studio.painting.painting import picture_of
from nmaptool.studio.requests import answer
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Window

# a message of the page is a few options
_LONGEST_MESSAGE = 1_000_000


def application(room: Room, token: str, hosts: tuple[str, ...]) -> ASGIApp:
    """Return the application that serves a document.

    Parameters
    ----------
    room : Room
    token : str
        The secret in the address that the user opens.
    hosts : tuple of str
        Host headers that are accepted.
    """

    @contextlib.asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        yield
        await run_in_threadpool(room.close)

    async def socket(websocket: WebSocket) -> None:
        await _converse(room, websocket)

    async def exported(request: Request) -> Response:
        return _exported(room, request.path_params["name"])

    async def dropped(request: Request) -> Response:
        return await receive(room, request)

    async def painted(request: Request) -> Response:
        place = request.query_params.get("place", "")
        return await _made(room, "image/png", picture_of, room, request.path_params["role"], place)

    async def overlaid(request: Request) -> Response:
        name = request.path_params["name"]
        return await _made(room, "application/octet-stream", overlay, room.worker, room.now, name)

    routes = [
        *page_routes(),
        Route("/files/{name}", dropped, methods=["POST"]),
        Route("/painted/{role}", painted),
        Route("/overlay/{name}", overlaid),
        Route("/export/{name}", exported),
        *mesh_routes(room),
        WebSocketRoute("/live", socket),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), token, hosts)


async def _made(room: Room, media_type: str, make: Callable[..., bytes], *given: Any) -> Response:
    """Return what ``make`` returns in a thread, or the line that says why it fails."""
    try:
        return Response(await run_in_threadpool(make, *given), media_type=media_type)
    except NmaptoolError as error:
        return JSONResponse(error_message(error, room.store), 400)


async def _converse(room: Room, websocket: WebSocket) -> None:
    """Exchange messages with one window until it closes."""
    await websocket.accept()
    window = Window()
    room.enter(window)
    sender = asyncio.create_task(_send(window, websocket))
    try:
        while True:
            text = await websocket.receive_text()
            said = answer(room, _message(text), window) if len(text) <= _LONGEST_MESSAGE else _malformed()
            if said is not None:
                window.put(said)
    except WebSocketDisconnect:
        pass
    finally:
        room.leave(window)
        sender.cancel()
        with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
            await sender


async def _send(window: Window, websocket: WebSocket) -> None:
    while True:
        message = await window.waiting.get()
        if isinstance(message, bytes):
            await websocket.send_bytes(message)
        else:
            await websocket.send_text(json.dumps(message))


def _message(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _malformed() -> dict[str, Any]:
    return {"kind": "error", "text": "the page sent a message that is too long; reload it"}


def _exported(room: Room, name: str) -> Response:
    """Return the file of an export, once: it is deleted afterwards."""
    job = room.exports.take(name)
    if job is None:
        return PlainTextResponse("this file is not there any more; export it again", 404)
    deleting = BackgroundTask(job.forget)
    return FileResponse(job.path, filename=job.name, media_type="application/octet-stream", background=deleting)
