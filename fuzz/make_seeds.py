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


def tileset() -> None:
    volume = {"box": [0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9]}
    moved = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]
    child = {"boundingVolume": volume, "geometricError": 0, "transform": moved, "contents": [{"uri": "b.b3dm"}]}
    root = {"boundingVolume": volume, "geometricError": 9, "refine": "ADD", "content": {"uri": "a.glb"}, "children": [child]}
    text = json.dumps({"asset": {"version": "1.1"}, "geometricError": 99, "root": root}, separators=(",", ":"))
    features = b'{"RTC_CENTER":[1,2,3]}  '
    put("tileset", "added", text.encode() + b"b3dm" + u32(1, 28 + len(features), len(features), 0, 0, 0) + features)


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


MASK = (1 << 64) - 1
STEP = 0x9E3779B97F4A7C15


def mix(z: int) -> int:
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & MASK
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB & MASK
    return z ^ (z >> 31)


def total(length: int, words: list[int]) -> int:
    """The sum of 64-bit words, as CULLET_baked has it."""
    state = STEP ^ length
    for word in words:
        state = (mix(state ^ word) + STEP) & MASK
    return mix(state)


def sum_of(content: bytes) -> int:
    padded = content + b"\0" * (-len(content) % 8)
    return total(len(content), list(struct.unpack(f"<{len(padded) // 8}Q", padded)))


def baked(plain: dict, body: bytes) -> dict:
    """The square with one coarser level: a triangle for both."""
    none = 0xFFFFFFFF
    tables = [
        u32(0, 1, 2, 0, 2, 3, 0, 1, 2),
        u32(0, 2, none, 0, 2, 1, 0, none),
        f32(0.5, 0.5, 0, 1, 0.75),
    ]
    document = json.loads(json.dumps(plain))
    views = document["bufferViews"]
    content = body
    for table in tables:
        content += b"\0" * (-len(content) % 64)
        views.append({"buffer": 0, "byteOffset": len(content), "byteLength": len(table)})
        content += table
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    document["buffers"] = [{"byteLength": len(content), "uri": uri}]
    words = []
    for x, y, z in SQUARE:
        words += struct.unpack("<2Q", f32(x, y, z) + u32(0))
    words += struct.unpack("<3Q", u32(0, 1, 2, 0, 2, 3)) + (2 | 1 << 32,)
    geometry = total(len(SQUARE), words)
    measured = [1 | 4 << 32, *struct.unpack("<2Q", struct.pack("<2d", 0.999, 1)), 7]
    chunk = total(geometry, [sum_of(b"chain"), *measured, 1, 3, *map(sum_of, tables)])
    size = sum(map(len, tables))
    document["meshes"][0]["extensions"] = {
        "CULLET_baked": {
            "geometry": f"{geometry:016x}",
            "levels": [
                {
                    "kind": "chain",
                    "parts": [3],
                    "indices": 2,
                    "clusters": 3,
                    "groups": 4,
                    "errors": [0.75, 0.75],
                    "measured": {"points": 1, "reversePoints": 4, "quantile": 0.999, "mostOver": 1, "seed": 7},
                }
            ],
        }
    }
    document["extensions"] = {
        "CULLET_baked": {
            "version": 1,
            "generator": "make_seeds",
            "hash": f"{total(1, [0, size, chunk]):016x}",
            "chunks": [{"mesh": 0, "bytes": size, "hash": f"{chunk:016x}"}],
        }
    }
    return document


def glb(document: dict, body: bytes, alignment: int) -> bytes:
    """A GLB whose binary buffer begins at a multiple of some bytes."""
    text = json.dumps(document).encode()
    text += b" " * (-(28 + len(text)) % alignment)
    body += b"\0" * (-len(body) % 4)
    chunks = u32(len(text)) + b"JSON" + text + u32(len(body)) + b"BIN\0" + body
    return b"glTF" + u32(2, 12 + len(chunks)) + chunks


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
    document["extensions"] = {
        "CULLET_cells_portals": {
            "cells": [
                {"name": "a", "pieces": [{"box": [[0, 0, 0], [4, 3, 4]]}]},
                {
                    "pieces": [
                        {
                            "planes": [
                                [1, 0, 0, 8], [-1, 0, 0, -4], [0, 1, 0, 3], [0, -1, 0, 0], [0, 0, 1, 4], [0, 0, -1, 0],
                            ]
                        }
                    ]
                },
            ],
            "portals": [
                {"cells": [0, 1], "polygon": [[4, 0, 1], [4, 0, 2], [4, 2, 2], [4, 2, 1]], "open": False, "node": 1}
            ],
            "mirrors": [{"cell": 0, "polygon": [[0, 0, 1], [0, 2, 1], [0, 2, 2], [0, 0, 2]]}],
            "walls": 0.5,
        }
    }
    put("gltf", "cells", json.dumps(document))
    del document["extensions"]
    full = baked(document, body)
    put("gltf", "baked", json.dumps(full))
    content = base64.b64decode(full["buffers"][0].pop("uri").split(",")[1])
    put("baked", "file", glb(full, content, 64))
    del document["buffers"][0]["uri"]
    put("gltf", "binary", glb(document, body, 4))


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


def i32(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}i", *values)


# A room of 128 units, cut in two at x = 0 by a plane without a wall: its six walls, then that plane.
WALLS = [((1, 0, 0), 64), ((-1, 0, 0), 64), ((0, 1, 0), 64), ((0, -1, 0), 64), ((0, 0, 1), 64), ((0, 0, -1), 64)]
PLANES = [*WALLS, ((1, 0, 0), 0)]
# Each wall's plane has rock (leaf 0) in front; behind the last are leafs 1 and 2.
NODES = [(k, -1, k + 1) for k in range(6)] + [(6, -2, -3)]
CORNERS = [(x, y, z) for x in (-64, 64) for y in (-64, 64) for z in (-64, 64)]
QUADS = [[c for c in range(8) if CORNERS[c][axis] * sign > 0] for axis in range(3) for sign in (1, -1)]
ENTITIES = (
    b'{\n"classname" "worldspawn"\n}\n{\n"classname" "info_player_start"\n"origin" "-32 0 -40"\n"angle" "90"\n}\n'
    b'{\n"classname" "light"\n"origin" "0 0 48"\n"light" "200"\n}\n{\n"classname" "func_wall"\n"model" "*1"\n}\n\0'
)


def directory(head: bytes, lumps: list[bytes]) -> bytes:
    at = len(head) + 8 * len(lumps)
    places, body = b"", b""
    for lump in lumps:
        places += i32(at + len(body), len(lump))
        body += lump + b"\0" * (-len(lump) % 4)
    return head + places + body


def quake(wide: bool, visibility: bytes, rows: tuple[int, int], version: int = 29) -> bytes:
    """Version 29, Half-Life's 30, or BSP2; walls belong to the world but for the last, which is a brush model."""
    word = (lambda *v: u32(*v)) if wide else (lambda *v: struct.pack(f"<{len(v)}H", *v))
    signed = (lambda *v: i32(*v)) if wide else (lambda *v: struct.pack(f"<{len(v)}h", *v))
    box = (lambda *v: f32(*v)) if wide else (lambda *v: struct.pack(f"<{len(v)}h", *v))
    planes = b"".join(f32(*n, d) + i32(3) for n, d in PLANES)
    nodes = b"".join(i32(p) + signed(a, b) + box(-64, -64, -64, 64, 64, 64) + word(0, 0) for p, a, b in NODES)
    leafs = [(-2, -1, (0,) * 6, 0, 0), (-1, rows[0], (0, -64, -64, 64, 64, 64), 0, 5), (-3, rows[1], (-64, -64, -64, 0, 64, 64), 5, 4)]
    leafs_lump = b"".join(i32(c, v) + box(*b) + word(f, n) + bytes(4) for c, v, b, f, n in leafs)
    marks = word(0, 2, 3, 4, 5, 1, 2, 3, 4)
    edges, surfedges, faces = word(0, 0), b"", b""
    for k, quad in enumerate(QUADS):
        a, b, c, d = quad
        for number, (v, w) in enumerate(((a, b), (b, d), (d, c), (c, a))):
            edges += word(v, w)
            surfedges += i32(1 + 4 * k + number)
        # Seen from within: the back of the plane.
        face = (k, 1, 4 * k, 4, k % 3)
        faces += i32(*face) if wide else struct.pack("<HHiHH", *face)
        faces += bytes(4) + i32(-1)
    texinfo = b"".join(f32(*range(8)) + u32(t, 0) for t in range(3))
    names = [b"wall", b"{fence", b"*water"]
    textures = i32(3, 16, 32, 48) + b"".join(n.ljust(16, b"\0") for n in names)
    def model(head: int, leafs: int, first: int, count: int) -> bytes:
        return f32(-64, -64, -64, 64, 64, 64, 0, 0, 0) + i32(head, 0, 0, 0, leafs, first, count)

    models = model(0, 2, 0, 5) + model(-1, 0, 5, 1)
    vertices = b"".join(f32(*c) for c in CORNERS)
    lumps = [ENTITIES, planes, textures, vertices, visibility, nodes, texinfo, faces, b"", b"", leafs_lump, marks, edges, surfedges, models]
    return directory(b"BSP2" if wide else i32(version), lumps)


def quake2() -> bytes:
    """The map of Quake with clusters: faces, planes and edges stay as they are."""
    old = quake(False, b"", (-1, -1))
    places = struct.unpack_from("<30i", old, 4)
    entities, planes, _, vertices, _, nodes, texinfo, faces, _, _, leafs, marks, edges, surfedges, models = (
        old[at : at + length] for at, length in zip(places[::2], places[1::2])
    )
    nodes = b"".join(i32(p, a, b) + nodes[24 * i + 8 : 24 * i + 24] for i, (p, a, b) in enumerate(NODES))
    # Solid, open, water.
    kinds = [(1, -1), (0, 0), (0x20, 1)]
    leafs = b"".join(i32(c) + struct.pack("<hh", k, 0) + leafs[28 * i + 8 : 28 * i + 24] + bytes(4) for i, (c, k) in enumerate(kinds))
    names = [(b"e1u1/wall", 0), (b"e1u1/glass", 0x10), (b"e1u1/*water", 8)]
    texinfo = b"".join(texinfo[40 * i : 40 * i + 32] + i32(f, 0) + n.ljust(32, b"\0") + i32(-1) for i, (n, f) in enumerate(names))
    models = b"".join(models[at : at + 40] + models[at + 56 : at + 64] for at in (0, 64))
    # Rows of what is seen and of what is heard.
    visibility = i32(2, 20, 21, 22, 23) + bytes((3, 3, 3, 3))
    lumps = [entities, planes, vertices, visibility, nodes, texinfo, faces, b"", leafs, marks, b"", edges, surfedges, models]
    return directory(b"IBSP" + i32(38), lumps + [b""] * 5)


def quake3() -> bytes:
    """A wall a face, the first as a curved patch and the second as a mesh."""
    texture = lambda name, flags, contents: name.ljust(64, b"\0") + u32(flags, contents)
    textures = texture(b"textures/wall", 0, 1) + texture(b"textures/sky", 4, 1) + texture(b"textures/water", 0, 0x20)
    planes = b"".join(f32(*n, d) for n, d in PLANES)
    nodes = b"".join(i32(p, a, b, -64, -64, -64, 64, 64, 64) for p, a, b in NODES)
    leafs = [(-1, (0,) * 6, 0, 0), (0, (0, -64, -64, 64, 64, 64), 0, 5), (1, (-64, -64, -64, 0, 64, 64), 5, 4)]
    leafs_lump = b"".join(i32(c, 0, *b, f, n, 0, 0) for c, b, f, n in leafs)
    vertices, meshverts, faces, first = b"", i32(0, 1, 2, 2, 1, 3), b"", 0
    for k, quad in enumerate(QUADS):
        normal = [-v for v in PLANES[k][0]]
        points = [CORNERS[c] for c in quad]
        if k == 0:
            points = [(64 + 32 * (i % 3 == 1), 64 * (i % 3 - 1), 64 * (i // 3 - 1)) for i in range(9)]
        vertices += b"".join(f32(*p, 0, 0, 0, 0, *normal) + bytes(4) for p in points)
        kind = (2, 3)[k] if k < 2 else 1
        size = (3, 3) if k == 0 else (0, 0)
        faces += i32(k % 3, -1, kind, first, len(points), 0, 6, -1, 0, 0, 0, 0) + f32(*range(9), *normal) + i32(*size)
        first += len(points)
    models = f32(-64, -64, -64, 64, 64, 64) + i32(0, 5, 0, 0) + f32(-64, -64, -64, 64, 64, 64) + i32(5, 1, 0, 0)
    visibility = i32(2, 8) + bytes((3, *[0] * 7, 3, *[0] * 7))
    marks = i32(0, 2, 3, 4, 5, 1, 2, 3, 4)
    lumps = [ENTITIES, textures, planes, nodes, leafs_lump, marks, b"", models, b"", b"", vertices, meshverts, b"", faces, b"", b"", visibility]
    return directory(b"IBSP" + i32(46), lumps)


def bsp() -> None:
    put("bsp", "quake", quake(False, bytes((3, 3)), (0, 1)))
    put("bsp", "one-cell", quake(False, bytes((3,)), (0, 0)))
    put("bsp", "unbaked", quake(False, b"", (-1, -1)))
    put("bsp", "bsp2", quake(True, bytes((3, 3)), (0, 1)))
    put("bsp", "halflife", quake(False, bytes((3, 3)), (0, 1), 30))
    put("bsp", "quake2", quake2())
    put("bsp", "quake3", quake3())


for make in (obj, ply, stl, off, prt, occscn, gltf, bsp, claims, tileset):
    make()
