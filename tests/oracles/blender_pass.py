#!/usr/bin/env python3
"""Pass a glTF file through real Blender (the `bpy` wheel, no window): import it, export it with custom properties.

    $LOFTSMAN_ORACLES/blender/bin/python blender_pass.py IN.glb [--edges] [--move NAME X Y Z] [--scale NAME FACTOR] [--apply]

The result is beside IN.glb, as IN-blender.glb. `--edges` exports loose edges and points too, which Blender leaves out unless told
otherwise. `--move` and `--scale` place an object (metres, z up) before that; `--apply` has all placements applied to the meshes.

stdout: {"tool": ..., "objects": {name: {"low": [x, y, z], "high": [x, y, z]}}}: of each object with a mesh, where its vertices are in the
        world, in Blender's metres with z up. Blender's own chatter goes to stderr.
exit:   0 passed; 1 not (the JSON has "error"); 2 bad usage.
"""
import argparse
import json
import os
import sys

_report_fd = os.dup(1)
os.dup2(2, 1)

import bpy  # noqa: E402


def bounds(thing):
    at = [thing.matrix_world @ vertex.co for vertex in thing.data.vertices]
    return {"low": [min(p[k] for p in at) for k in range(3)], "high": [max(p[k] for p in at) for k in range(3)]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", metavar="IN.glb")
    parser.add_argument("--edges", action="store_true")
    parser.add_argument("--move", nargs=4, metavar=("NAME", "X", "Y", "Z"))
    parser.add_argument("--scale", nargs=2, metavar=("NAME", "FACTOR"))
    parser.add_argument("--apply", action="store_true")
    args = parser.parse_args()
    report = {"tool": "Blender " + bpy.app.version_string}
    try:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.import_scene.gltf(filepath=args.file)
        if args.move:
            bpy.data.objects[args.move[0]].location = [float(x) for x in args.move[1:]]
        if args.scale:
            bpy.data.objects[args.scale[0]].scale = [float(args.scale[1])] * 3
        if args.apply:
            bpy.ops.object.select_all(action="SELECT")
            bpy.ops.object.transform_apply(isolate_users=True)
        bpy.context.view_layer.update()
        shown = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing.data.vertices]
        report["objects"] = {thing.name: bounds(thing) for thing in shown}
        bpy.ops.export_scene.gltf(
            filepath=os.path.splitext(args.file)[0] + "-blender.glb",
            export_extras=True,
            use_mesh_edges=args.edges,
            use_mesh_vertices=args.edges,
        )
    except Exception as problem:  # noqa: BLE001 - any failure is this report's answer
        report["error"] = "%s: %s" % (type(problem).__name__, problem)
    text = (json.dumps(report) + "\n").encode()
    while text:
        text = text[os.write(_report_fd, text):]
    sys.stdout.flush()
    # Leave without Blender's teardown, which can crash after the answer is out.
    os._exit(1 if "error" in report else 0)


if __name__ == "__main__":
    main()
