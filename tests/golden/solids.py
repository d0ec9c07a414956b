#!/usr/bin/env python3
"""Areas and volumes of the solids of STEP files, in millimetres, by OpenCASCADE (the `cadquery-ocp` wheel).

    $LOFTSMAN_ORACLES/python/bin/python tests/golden/solids.py > tests/golden/solids.json

Files are those of tests/data/step; the area is that of all faces as placed, solids are in the file's order.
"""
import json
import os
import pathlib

_out = os.dup(1)
os.dup2(2, 1)

from OCP.BRepGProp import BRepGProp  # noqa: E402
from OCP.GProp import GProp_GProps  # noqa: E402
from OCP.STEPControl import STEPControl_Reader  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402

EXACT = 1e-10


def area(shape):
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, found, EXACT)
    return found.Mass()


def volume(shape):
    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, found, EXACT)
    return found.Mass()


files = {}
for path in sorted((pathlib.Path(__file__).parents[1] / "data" / "step").glob("*.st*p")):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()
    solids = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    while explorer.More():
        solids.append([area(explorer.Current()), volume(explorer.Current())])
        explorer.Next()
    files[path.name] = {"area": area(shape), "solids": solids}
os.write(_out, (json.dumps(files, indent=1) + "\n").encode())
