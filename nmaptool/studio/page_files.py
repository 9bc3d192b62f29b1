"""The files of the page, read once and served from memory."""

from __future__ import annotations

import mimetypes
from pathlib import Path

from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

PAGE = Path(__file__).with_name("page")
# Windows may know other types for these
_TYPES = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}
_HEAD_ENDS = "  </head>"


def page_routes() -> list[BaseRoute]:
    """Return the routes of the page and of its modules and styles, below ``/page``."""
    files = {path.relative_to(PAGE).as_posix(): path.read_bytes() for path in PAGE.rglob("*") if path.is_file()}
    html = files["index.html"].decode()
    # the browser fetches all modules at once, not each when the one before names it
    modules = "".join(
        f'    <link rel="modulepreload" href="page/{name}" />\n' for name in files if name.endswith(".js")
    )
    html = html.replace(_HEAD_ENDS, f"{modules}{_HEAD_ENDS}")

    async def page(_: Request) -> Response:
        return Response(html, media_type="text/html")

    async def file(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in files:
            return PlainTextResponse("no such file", 404)
        ending = Path(name).suffix
        return Response(files[name], media_type=_TYPES.get(ending) or mimetypes.guess_type(name)[0])

    return [Route("/", page), Route("/page/{name:path}", file)]
