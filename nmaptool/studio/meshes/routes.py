"""What the camera panel fetches: the mesh to display, and what a bake with its options would give."""

from __future__ import annotations

import json

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from nmaptool.core.errors import LimitError, NmaptoolError
from nmaptool.studio.meshes.open_meshes import checked
from nmaptool.studio.room import Room

_LONGEST = 100_000


def mesh_routes(room: Room) -> list[BaseRoute]:
    """Return the routes of the open meshes."""

    async def shown(request: Request) -> Response:
        try:
            one = room.sources.meshes.ready(request.path_params["id"])
            return Response(one.bytes, media_type="application/octet-stream")
        except NmaptoolError as error:
            return JSONResponse({"text": str(error)}, 400)

    async def check(request: Request) -> Response:
        try:
            one = room.sources.meshes.ready(request.path_params["id"])
            text = b""
            async for piece in request.stream():
                text += piece
                if len(text) > _LONGEST:
                    raise LimitError("the page sent a message that is too long; reload it")
            values = json.loads(text)
        except NmaptoolError as error:
            return JSONResponse({"error": str(error)}, 400)
        except ValueError:
            return JSONResponse({"error": "the page sent no options; reload it"}, 400)
        return JSONResponse(await run_in_threadpool(checked, one, values))

    return [Route("/mesh/{id}", shown), Route("/mesh/{id}/check", check, methods=["POST"])]
