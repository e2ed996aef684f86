#!/usr/bin/env python3
"""Writes the small seeds of fuzz/seeds, one folder for each target."""

import base64
import json
import struct
from pathlib import Path

SEEDS = Path(__file__).parent / "seeds"


def put(target: str, name: str, content: bytes | str) -> None:
    folder = SEEDS / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def f32(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}f", *values)


def u32(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def obj() -> None:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)
    put("obj", "square", corners + "f 1 2 3 4\n")
    put("obj", "negative", corners + "vt 0 0\nvn 0 0 1\nf -4/1/1 -3//1 -2/1 -1\n")
    put("obj", "ahead", "f 1 2 3\n" + corners)
    put("obj", "groups", f"mtllib a.mtl\no a\n{corners}usemtl m\nf 1 2 3\ng b\nf 3 4 1\no a\nf 1 3 2\n")
    put("obj", "joined", "v 0 \\\n 0 0 1 1 1\r\nv 1 0 0\r\nv 1e-3 +2. .5\nf 1 \\\r\n 2 3 # end\n")
    put("obj", "concave", "v 2 1 0\nv 0 2 0\nv .5 1 0\nv 0 0 0\nv 1 0.2 1\nf 1 2 3 4 5\nl 1 2\np 1\ncurv 1\n")


def ply() -> None:
    def head(kind: str, rest: str) -> str:
        return (
            f"ply\nformat {kind} 1.0\ncomment seed\nelement vertex 4\nproperty float x\n"
            f"property float y\nproperty float z\n{rest}end_header\n"
        )

    rows = "".join(f"{x} {y} {z}\n" for x, y, z in SQUARE)
    face = "element face 1\nproperty uchar red\nproperty list uchar int vertex_indices\n"
    strip = "element tristrips 1\nproperty list int int vertex_indices\n"
    other = "element edge 1\nproperty list ushort double w\nproperty int8 v\n"
    put("ply", "ascii", head("ascii", face) + rows + "255 4 0 1 2 3\n")
    put("ply", "strips", head("ascii", strip) + rows + "6 0 1 3 -1 2 1\n")
    put("ply", "other", head("ascii", other + face) + rows + "2 1.5 2e3 -7\n0 3 2 1 0\n")
    for kind, order in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(f"{order}3f", *p) for p in SQUARE)
        body += struct.pack(f"{order}BB4i", 7, 4, 0, 1, 2, 3)
        put("ply", kind, head(f"binary_{kind}_endian", face).encode() + body)


def stl() -> None:
    triangle = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n"
    put("stl", "ascii", f"solid a\n{triangle}endsolid a\n")
    put("stl", "two", f"solid a\n{triangle}endsolid\nsolid b c\n{triangle}{triangle}endsolid b c\n")
    put("stl", "four", f"solid\n{triangle.replace('endloop', 'vertex 0 0 1' + chr(10) + 'endloop')}endsolid\n")
    body = u32(2) + 2 * (f32(0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0) + b"\0\0")
    put("stl", "binary", b"binary".ljust(80, b"\0") + body)
    put("stl", "binary-solid", b"solid".ljust(80) + body)


def off() -> None:
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in SQUARE)
    put("off", "plain", f"OFF\n4 2 0\n{rows}4 0 1 2 3\n3 2 1 0 255 0 0\n")
    put("off", "one-line", f"OFF 4 1 0\n{rows}4 0 1 2 3\n")
    put("off", "comments", f"# a\nOFF # b\n4 1 # c\n{rows}# d\n4 0 1 2 3\n")
    put("off", "colours", "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n")
    put("off", "variants", "STCNOFF\n1 0 0\n0 0 0 1 2 3 4 5 6\n")


def occscn() -> None:
    box = f32(0, 0, 0, 1, 1, 0)
    vertices = b"".join(f32(*p) for p in SQUARE)
    camera = f32(*range(16), 1, 2, 3, 0.5)
    put(
        "occscn",
        "square",
        b"OCCSCN01" + u32(4, 2, 2, 1, 1, 0) + vertices + u32(0, 1, 2, 0, 2, 3)
        + u32(1, 1) + box + u32(0, 1) + box + camera + f32(-1, -1, -1, 1, 2, 3),
    )
    put("occscn", "nothing", b"OCCSCN01" + u32(0, 0, 0, 0, 0, 0))


def gltf() -> None:
    body = b"".join(f32(*p) for p in SQUARE) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    uri = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [-1, 2, 1]}, {"mesh": 0, "translation": [1, 2, 3]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"doubleSided": True, "alphaMode": "MASK"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [{"byteLength": len(body), "uri": uri}],
    }
    put("gltf", "embedded", json.dumps(document))
    del document["buffers"][0]["uri"]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = u32(len(text)) + b"JSON" + text + u32(len(body)) + b"BIN\0" + body
    put("gltf", "binary", b"glTF" + u32(2, 12 + len(chunks)) + chunks)


def prt() -> None:
    square = "({0} 0 0 ) ({0} 1 0 ) ({0} 1 1 ) ({0} 0 1 ) "
    portals = [f"4 {k} {k + 1} {square.format(k)}\n" for k in range(2)]
    put("prt", "prt1", "PRT1\n3\n2\n" + "".join(portals))
    put("prt", "quake3", "PRT1\n3\n2\n1\n" + "".join(p.replace(" (", " 0 (", 1) for p in portals) + "4 1 " + square.format(9) + "\n")
    put("prt", "prt2", "PRT2\n4\n3\n2\n" + "".join(portals) + "0 3 -1\n1 -1\n2 -1\n")
    put("prt", "prt1-am", "PRT1-AM\n3\n2\n4\n" + "".join(portals) + "0\n1\n2\n0\n")


def claims() -> None:
    def surface(head: bytes, corners: list[tuple[int, int, int]], triangles: list[tuple[int, int, int]]) -> bytes:
        # The target takes the first two thirds of what follows the head for corners, of six bytes each.
        places = b"".join(bytes((v & 255, 0)) for p in corners for v in p)
        faces = b"".join(bytes(t) for t in triangles)
        wanted = (len(places) + 1) // 2
        return head.ljust(12, b"\0") + places + faces.ljust(wanted, b"\0")

    quad = [(-16, -16, -32), (16, -16, -32), (16, 16, -32), (-16, 16, -32)]
    put("claims", "quad", surface(b"", quad, [(0, 1, 2), (0, 2, 3)]))
    put("claims", "fold", surface(b"\x01", [*quad, (-14, -16, -31), (-14, 16, -31)], [(0, 1, 2), (0, 2, 3), (0, 4, 5), (0, 5, 3)]))
    floor = [(-40, -4, 8), (40, -4, 8), (40, -4, -120), (-40, -4, -120)]
    put("claims", "floor", surface(b"\x10", floor, [(0, 1, 2), (0, 2, 3)]))
    fan = [*quad, (0, 20, -20), (8, 0, -16)]
    put("claims", "parallel", surface(b"\x04\0\0\0\0\0\0\x01", fan, [(0, 1, 2), (0, 2, 3), (0, 2, 4), (2, 0, 5), (0, 1, 2)]))


for make in (obj, ply, stl, off, prt, occscn, gltf, claims):
    make()
