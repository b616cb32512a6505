#!/usr/bin/env python3
"""guide_pictures.py FURROW CONTENT OUT: makes models, images and recipes, and of them the artist guide's pictures of direction sources, map
sources and weld traps.

The models: the demo's face, a panel that its morph target squeezes upright, and small sheets for the weld. Status 77: there is no OpenGL."""

import json
import math
import os
import re
import struct
import subprocess
import sys
import zlib


def write_png(file, width, height, pixel):
    """pixel(u, v) -> (r, g, b) in [0, 1], v down."""
    rows = b""
    for y in range(height):
        rows += b"\0" + bytes(
            min(255, max(0, round(255 * c))) for x in range(width) for c in pixel((x + 0.5) / width, (y + 0.5) / height))
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(file, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


class Model:
    """A .glb of one mesh with one morph target."""

    def __init__(self, target):
        self.target, self.bytes, self.views, self.accessors, self.primitives = target, b"", [], [], []

    def add(self, rows, kind, component, form):
        data = b"".join(struct.pack("<" + form, *row) for row in rows)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data + b"\0" * (-len(data) % 4)
        self.accessors.append({"bufferView": len(self.views) - 1, "componentType": component, "count": len(rows), "type": kind})
        return len(self.accessors) - 1

    def sheet(self, columns, rows, at, moved, uv=lambda u, v: (u, v)):
        """columns x rows quads of at(u, v); `moved`: what the target adds at a position."""
        grid = [(x / columns, y / rows) for y in range(rows + 1) for x in range(columns + 1)]
        positions = [at(u, v) for u, v in grid]
        corners = [[y * (columns + 1) + x + c for c in (0, 1, columns + 2, 0, columns + 2, columns + 1)]
                   for y in range(rows) for x in range(columns)]
        self.primitives.append({
            "attributes": {"POSITION": self.add(positions, "VEC3", 5126, "3f"),
                           "TEXCOORD_0": self.add([uv(u, v) for u, v in grid], "VEC2", 5126, "2f")},
            "indices": self.add([(i,) for quad in corners for i in quad], "SCALAR", 5125, "I"),
            "targets": [{"POSITION": self.add([moved(*p) for p in positions], "VEC3", 5126, "3f")}]})

    def write(self, file):
        text = json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"name": "Sheet", "primitives": self.primitives, "extras": {"targetNames": [self.target]}}], "accessors": self.accessors,
            "bufferViews": self.views, "buffers": [{"byteLength": len(self.bytes)}]}).encode()
        text += b" " * (-len(text) % 4)
        with open(file, "wb") as out:
            out.write(b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(self.bytes)))
            out.write(struct.pack("<I", len(text)) + b"JSON" + text)
            out.write(struct.pack("<I", len(self.bytes)) + b"BIN\0" + self.bytes)


def panel(file):
    model = Model("squeeze")
    model.sheet(64, 48, lambda u, v: (2 * u - 1, 1.6 * (0.5 - v), 0.3 * math.cos(math.pi * (u - 0.5))),
               lambda x, y, z: (0, -0.22 * math.cos(1.2 * x) * y, 0))
    model.write(file)


# Sheets of 2 x 1.6, cut at x = 0 or y = 0.
def halves(file, *parts):
    model = Model("squeeze")
    for at, uv in parts:
        model.sheet(5, 8, at, lambda x, y, z: (-0.3 * x, 0, 0), uv)
    model.write(file)


def left(u, v):
    return (u - 1, 1.6 * (0.5 - v), 0)


def right(u, v):
    return (u, 1.6 * (0.5 - v), 0)


def rounded(u, v):
    x, y, z = left(u, v)
    return (x + (2e-7 * math.sin(977 * y) if u == 1 else 0), y, z)


def upper(u, v):
    return (2 * u - 1, 0.8 - 0.8 * v, 0)


def lower(u, v):
    return (2 * u - 1, -0.8 * v, 0)


def part(x, y, side):
    return (0, side * 0.25 * (1 - x * x) * (1 - abs(y) / 0.8), 0)


# The edges of a quilt's diamonds, as slopes and as heights.
def diamonds(u, v):
    a, b = (6 * (u + v)) % 1, (6 * (u - v)) % 1
    return a, b


def quilt_normal(u, v):
    slope = [0.9 * math.copysign(max(0, 1 - 4 * min(t, 1 - t)), 0.5 - t) for t in diamonds(u, v)]
    x, y = slope[0] + slope[1], slope[0] - slope[1]
    n = (-x, y, 1)
    length = math.sqrt(sum(c * c for c in n))
    return [0.5 + 0.5 * c / length for c in n]


def ring_height(u, v):
    r = math.hypot(u - 0.5, 0.8 * (v - 0.5))
    return [0.5 + 0.5 * math.cos(48 * r) * max(0, 1 - 2 * r)] * 3


# Around the middle, as the lines do that stand across rays.
def swirl(u, v):
    x, y = u - 0.5, 0.5 - v
    r = max(math.hypot(x, y), 1e-3)
    return [0.5 - 0.5 * y / r, 0.5 + 0.5 * x / r, 0]


def main():
    made = []
    guide = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../docs/artist_guide.md")
    furrow, content, out = map(os.path.abspath, sys.argv[1:4])
    work = os.path.join(out, "models")
    os.makedirs(work, exist_ok=True)
    os.chdir(work)
    panel("panel.glb")
    write_png("quilt.png", 512, 512, quilt_normal)
    write_png("rings.png", 512, 512, ring_height)
    write_png("flow.png", 64, 64, swirl)
    # Charts as an exporter leaves them: the two sides of the seam are vertices of their own.
    first, second = lambda u, v: (0.5 * u, v), lambda u, v: (1 - 0.5 * u, 0.5 * v)
    halves("seam.glb", (left, first), (right, second))
    halves("jitter.glb", (rounded, first), (right, second))
    lips = Model("open")
    lips.sheet(10, 4, upper, lambda x, y, z: part(x, y, 1), lambda u, v: (u, 0.5 * v))
    lips.sheet(10, 4, lower, lambda x, y, z: part(x, y, -1), lambda u, v: (u, 0.5 + 0.5 * v))
    lips.write("lips.glb")

    def picture(name, model, layer, options, size="240x200", **more):
        recipe = name + ".json"
        with open(recipe, "w", encoding="utf-8") as text:
            json.dump({**more, "layers": [{"name": "creases", "direction": {"axis": [0, 1, 0]}, "mask": "none", **layer}]}, text, indent=1)
        asset = name + ".furrow"
        subprocess.run([furrow, "cook", model, "-o", asset, "--recipe", recipe, "--quiet"], check=True)
        rendered = subprocess.run(
            [furrow, "render", asset, "-o", os.path.join(out, name + ".png"), "--size", size, "--layer", "creases", *options])
        if rendered.returncode:
            sys.exit(77 if rendered.returncode == 3 else 1)
        made.append(name + ".png")

    squeezed = ["--morph", "squeeze=1", "--yaw", "25"]
    for preset, spacing in (("skin", 0.11), ("skin_fine", 0.05), ("cloth", 0.2), ("cloth_puckers", 0.12)):
        picture("map_" + preset, "panel.glb", {"compress": {"synthesize": {"preset": preset, "spacing": spacing}}}, squeezed, mapSize=1024)
    picture("map_normal", "panel.glb", {"compress": {"normal": "quilt.png"}}, squeezed, mapSize=512)
    picture("map_height", "panel.glb", {"compress": {"height": "rings.png", "depth": 0.06}}, squeezed, mapSize=512)
    cloth = {"synthesize": {"preset": "cloth", "spacing": 0.2, "depth": 0.06}}
    picture("map_alpha", "panel.glb", {"compress": cloth}, [*squeezed, "--shading", "alpha"], mapSize=1024)
    picture("map_alpha_lit", "panel.glb", {"compress": {**cloth, "light": [0, 1, 0.5]}}, [*squeezed, "--shading", "alpha"], mapSize=1024)

    point = ["--view", "point", "--zoom", "1.3"]
    picture("weld_seam", "seam.glb", {"compress": "none"}, point)
    picture("weld_lips", "lips.glb", {"compress": "none"}, [*point, "--morph", "open=0.3"])
    picture("weld_jitter", "jitter.glb", {"compress": "none"}, point, weld={"tolerance": 0})

    darts = ["--view", "direction", "--zoom", "2.2", "--target", "0", "0.02", "0", "--yaw", "12"]
    for source, direction in (("animation", "animation"), ("axis", {"axis": [0, 1, 0]}), ("guides", {"guides": {"lines": "ForeheadLines"}}),
                              ("attribute", {"attribute": "_DIR_EYE"}), ("texture", {"texture": "flow.png"}), ("map", "map")):
        layer = {"meshes": ["Face"], "materials": ["skin"], "direction": direction, "compress": {"height": "rings.png", "depth": 0.001}}
        picture("direction_" + source, os.path.join(content, "face.glb"), layer, darts, "320x320", mapSize=512)

    with open(guide, encoding="utf-8") as text:
        shown = re.findall(r"images/((?:direction|map|weld)_\w+\.png)", text.read())
    if sorted(shown) != sorted(made):
        sys.exit(f"the guide shows {sorted(shown)}, and these were made: {sorted(made)}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main()
