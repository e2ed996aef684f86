"""What a notebook shows."""

from __future__ import annotations

import base64
import struct
import zlib
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from . import _native

_STYLE = "style='text-align:right;padding:2px 10px;border:none'"
_LEFT = "style='text-align:left;padding:2px 10px;border:none'"


def png(color: npt.NDArray[np.uint8]) -> bytes:
    """The bytes of a PNG file of an array of the shape (height, width, 3)."""
    height, width, _ = color.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), color.reshape(height, width * 3)], axis=1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def picture(data: bytes, title: str) -> str:
    """A PNG within the page."""
    source = base64.b64encode(data).decode()
    return f"<img title='{escape(title, quote=True)}' src='data:image/png;base64,{source}'>"


def table(heads: list[str], rows: list[list[Any]]) -> str:
    """Numbers to the right, the first column to the left."""
    cells = "".join(f"<th {_STYLE if at else _LEFT}>{escape(h)}</th>" for at, h in enumerate(heads))
    lines = [f"<tr>{cells}</tr>"]
    for row in rows:
        texts = [f"{v:,}".replace(",", "\u202f") if isinstance(v, int) else str(v) for v in row]
        cells = "".join(f"<td {_STYLE if at else _LEFT}>{escape(t)}</td>" for at, t in enumerate(texts))
        lines.append(f"<tr>{cells}</tr>")
    return f"<table style='border-collapse:collapse'>{''.join(lines)}</table>"


def funnel(rows: npt.NDArray[Any]) -> str:
    """Counts in and out of each stage, as a table."""
    names = ["instances", "clusters", "triangles"]
    lines: list[list[Any]] = []
    if len(rows):
        lines.append(["all", "", *(int(rows[0][f"{n}_in"]) for n in names)])
    for row in rows:
        left = [int(row[f"{n}_out"]) for n in names]
        lines.append([str(row["stage"]), str(row["unit"]), *left])
    return table(["left by", "testing", *names], lines)


def of_result(result: _native.Result) -> str:
    """What the camera sees, the same from outside, and the funnel; the funnel alone where the scene has changed."""
    from . import _native

    parts = [f"<p>{escape(repr(result)[1:-1])}</p>"]
    try:
        seen, outside = result.pictures(480)
        parts.append(picture(seen, "what the camera sees"))
        parts.append(picture(outside, "the scene from outside, by what culled it"))
    except _native.StaleError as stale:
        parts.append(f"<p>{escape(str(stale))}</p>")
    return "".join(parts) + funnel(result.funnel)
