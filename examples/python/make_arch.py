"""Writes a semicircular arch as a COMPAS assembly, for `stonestack check`: python3 make_arch.py FILE.json [WEDGES]"""
import json
import sys
from math import cos, pi, sin
from typing import Any

INNER, OUTER, DEPTH = 1.0, 1.25, 0.5  # metres: radii, and extent along y
# The eight corners of a wedge: 4 * (second joint) + 2 * (outer) + (behind); faces are seen from outside
FACES = {"0": [0, 1, 3, 2], "1": [4, 6, 7, 5], "2": [0, 4, 5, 1], "3": [2, 3, 7, 6], "4": [0, 2, 6, 4],
         "5": [1, 5, 7, 3]}


def wedge(first: float, second: float, support: bool) -> "dict[str, Any]":
    """The block between two angles; the springers do not move."""
    corners = [(r * cos(angle), y, r * sin(angle)) for angle in (first, second) for r in (INNER, OUTER)
               for y in (0.0, DEPTH)]
    vertices = {str(i): {"x": x, "y": y, "z": z} for i, (x, y, z) in enumerate(corners)}
    return {"is_support": support, "block": {"data": {"vertex": vertices, "face": FACES}}}


count = int(sys.argv[2]) if len(sys.argv) > 2 else 15
nodes = {str(k): wedge(pi * k / count, pi * (k + 1) / count, k in (0, count - 1)) for k in range(count)}
with open(sys.argv[1], "w", encoding="utf-8") as file:
    json.dump({"data": {"graph": {"data": {"node": nodes}}}}, file)
print(f"{sys.argv[1]}: {count} wedges")
