#!/usr/bin/env python3
"""Subdivide cages with real Blender (the `bpy` wheel, no window) and print what its modifier makes of each, all in one launch.

    $LOFTSMAN_ORACLES/blender/bin/python blender_subdivide.py CAGE.json... [--cage N] [--levels N] [--limit]
    $LOFTSMAN_ORACLES/blender/bin/python blender_subdivide.py CAGE.obj...  [--levels N] [--limit] [--boundary KIND]

CAGE.json: {"points": [[x, y, z]...], "faces": [[i...]...], "creases": [[i, j, sharpness]...], "corners": [[i, sharpness]...],
        "boundary": "edge-only" | "edge-and-corner", "levels": n, "limit": true | false}; only points and faces are needed.
        With `--cage N` the N-th of the file's "cages" (tests/golden/opensubdiv.json; from 0).
CAGE.obj: `v` and `f` lines; there are no creases in one.
`--levels`, `--limit` and `--boundary` come before what the file says. The default is one level, "edge-only", no limit.

stdout: for each file, in order, a line {"file": ..., "tool": ..., "levels": n, "points": [...], "faces": [...]}, points in single
        precision, which is Blender's; or, where it was not subdivided, {"file": ..., "error": ...}. Blender's own chatter goes to stderr.
exit:   0 all were subdivided; 1 not all; 2 bad usage.

How Blender is asked: the modifier SUBSURF of the type CATMULL_CLARK; boundary_smooth ALL for edge-only and PRESERVE_CORNERS for
edge-and-corner; use_limit_surface where the limit is asked for. Blender keeps a sharpness s as c in 0..1 with s = 10 c^2, in single
precision: c = sqrt(s / 10), so s comes back within 1e-6; 10 and above is infinite, as in OpenSubdiv. Loose points and loose edges
are not for this script. With the limit the points are those of the limit surface at the vertices of the refined mesh.

Where it differs from OpenSubdiv on the same cage (found on the cages of tests/golden/opensubdiv.json and on random ones; otherwise they
agree within 1e-6): to the sharpness of a vertex of two edges, inside or on the boundary, Blender adds the smaller one of these edges', 10
at most in all; with the limit, an end of an infinitely sharp crease is only approximated, to some 6e-5. Two faces with all their vertices
in common are refused.
"""
import argparse
import json
import math
import os
import sys

_report_fd = os.dup(1)
os.dup2(2, 1)

import bpy  # noqa: E402

BOUNDARIES = {"edge-only": "ALL", "edge-and-corner": "PRESERVE_CORNERS"}


def read_obj(path):
    points, faces = [], []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                points.append([float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                at = [int(word.split("/")[0]) for word in words[1:]]
                faces.append([i - 1 if i > 0 else len(points) + i for i in at])
    return {"points": points, "faces": faces}


def read(path, args):
    if path.lower().endswith(".obj"):
        cage = read_obj(path)
    else:
        with open(path, encoding="utf-8") as file:
            cage = json.load(file)
        if args.cage is not None:
            # There "levels" says how far the limits were taken, not what is asked of Blender.
            cage = {**cage["cages"][args.cage], "levels": 1}
    levels = args.levels if args.levels is not None else cage.get("levels", 1)
    boundary = args.boundary or cage.get("boundary", "edge-only")
    return cage, levels, BOUNDARIES[boundary], args.limit or cage.get("limit", False)


def blender_crease(sharpness):
    return math.sqrt(min(max(sharpness, 0.0), 10.0) / 10.0)


def build(cage):
    mesh = bpy.data.meshes.new("cage")
    mesh.from_pydata(cage["points"], [], cage["faces"])
    if len(mesh.polygons) != len(cage["faces"]) or mesh.validate(verbose=True):
        raise RuntimeError("Blender does not take the cage as it is")
    if cage.get("creases"):
        edges = {tuple(sorted(edge.vertices)): edge.index for edge in mesh.edges}
        crease = mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
        for a, b, sharpness in cage["creases"]:
            crease.data[edges[min(a, b), max(a, b)]].value = blender_crease(sharpness)
    if cage.get("corners"):
        crease = mesh.attributes.new("crease_vert", "FLOAT", "POINT")
        for vertex, sharpness in cage["corners"]:
            crease.data[vertex].value = blender_crease(sharpness)
    return mesh


def subdivide(mesh, levels, boundary, limit):
    thing = bpy.data.objects.new("cage", mesh)
    bpy.context.scene.collection.objects.link(thing)
    modifier = thing.modifiers.new("subdivision", "SUBSURF")
    modifier.subdivision_type = "CATMULL_CLARK"
    modifier.levels = modifier.render_levels = levels
    modifier.boundary_smooth = boundary
    modifier.use_limit_surface = limit
    modifier.use_creases = True
    # How finely the limit is told from its approximation near extraordinary vertices: the most that Blender allows.
    modifier.quality = type(modifier).bl_rna.properties["quality"].hard_max
    bpy.context.view_layer.update()
    seen = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    out = seen.to_mesh()
    return [list(vertex.co) for vertex in out.vertices], [list(face.vertices) for face in out.polygons]


def report_on(path, args):
    report = {"file": path, "tool": "Blender " + bpy.app.version_string}
    try:
        # Nothing is left of the cage before.
        bpy.ops.wm.read_factory_settings(use_empty=True)
        cage, levels, boundary, limit = read(path, args)
        report["levels"], report["boundary_smooth"], report["limit"] = levels, boundary, limit
        report["points"], report["faces"] = subdivide(build(cage), levels, boundary, limit)
    except Exception as problem:  # noqa: BLE001 - any failure is this report's answer
        report["error"] = "%s: %s" % (type(problem).__name__, problem)
    return report


def print_line(report):
    text = (json.dumps(report) + "\n").encode()
    while text:
        text = text[os.write(_report_fd, text):]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", metavar="CAGE", nargs="+")
    parser.add_argument("--cage", type=int, metavar="N")
    parser.add_argument("--levels", type=int, metavar="N")
    parser.add_argument("--boundary", choices=sorted(BOUNDARIES))
    parser.add_argument("--limit", action="store_true")
    args = parser.parse_args()
    status = 0
    for path in args.files:
        report = report_on(path, args)
        print_line(report)
        status |= "error" in report
    sys.stdout.flush()
    # Leave without Blender's teardown, which can crash after the answer is out.
    os._exit(int(status))


if __name__ == "__main__":
    main()
