"""A studio of this process, and a client that speaks to it as the page does."""

import contextlib
import http.client
import json
import struct
import threading
import time

import numpy as np
from websockets.sync.client import connect

from nmaptool.studio.document import opened
from nmaptool.studio.server import Studio


class Client:
    """A browser, as far as the server can tell."""

    def __init__(self, studio):
        self.studio = studio
        self.host = studio.address.partition("//")[2].partition("/")[0]
        self.token = studio.address.partition("token=")[2]
        self.cookie = {"Cookie": f"nmap-studio={self.token}"}

    def get(self, path, headers=None, method="GET", body=None):
        connection = http.client.HTTPConnection(self.host, timeout=20)
        connection.request(method, path, body, headers=self.cookie if headers is None else headers)
        answer = connection.getresponse()
        answer.body = answer.read()
        connection.close()
        return answer

    def send(self, path, body, name=None):
        """Drop a file on the page; return the answer of the server."""
        headers = {**self.cookie, "Origin": f"http://{self.host}"}
        return self.get(f"/files/{name or path.name}", headers, "POST", body if body is not None else path.read_bytes())

    def drop(self, path, name=None):
        """Drop a file on the page; return its name in the store and its kind."""
        answer = self.send(path, None, name)
        assert answer.status == 200, answer.body
        return json.loads(answer.body)

    def live(self, origin=None, headers=None):
        origin = f"http://{self.host}" if origin is None else origin
        more = self.cookie if headers is None else headers
        return connect(f"ws://{self.host}/live", origin=origin, additional_headers=more, max_size=None)


def decoded(data):
    """The header, the fields and the mask of a frame."""
    (length,) = struct.unpack_from("<I", data)
    assert length % 4 == 0
    header = json.loads(data[4 : 4 + length])
    shape, at, fields = (header["rows"], header["cols"]), 4 + length, {}
    for field in header["fields"]:
        numbers = np.frombuffer(data, "<u2", shape[0] * shape[1], at).reshape(shape)
        at += numbers.nbytes
        fields[field["name"]] = field["low"] + numbers * (field["high"] - field["low"]) / 65535
    count = shape[0] * shape[1]
    surface = np.unpackbits(np.frombuffer(data, np.uint8, -1, at))
    assert len(surface) == count + -count % 8
    surface = surface[:count].reshape(shape)
    return header, fields, surface


@contextlib.contextmanager
def running(studio):
    """A client of a studio that runs meanwhile."""
    thread = threading.Thread(target=studio.run)
    thread.start()
    try:
        while not studio.is_started:
            time.sleep(0.01)
        yield Client(studio)
    finally:
        studio.stop()
        thread.join(10)
    assert not thread.is_alive()


def served(*files, root=None, **more):
    """A client of a server that shows files, or nothing."""
    return running(Studio(opened([str(file) for file in files]), root=root or files[0].parent / "state", **more))


def until(live, kind, holds=lambda found: True):
    """The next message of a kind that holds something, or the next frame."""
    while True:
        message = live.recv(timeout=20)
        if isinstance(message, bytes):
            if kind == "frame" and holds(decoded(message)):
                return decoded(message)
            continue
        found = json.loads(message)
        assert found["kind"] != "error" or kind in ("error", "export"), found["text"]
        if found["kind"] == kind and holds(found):
            return found


def ask(live, **message):
    live.send(json.dumps(message))


def exported(live, **wanted):
    """The last message about an export."""
    ask(live, do="export", **wanted)
    while True:
        found = until(live, "export")
        if found["state"] not in ("begun", "running"):
            return found
