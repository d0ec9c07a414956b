"""Writes curves of every kind as Blender's OBJ exporter writes them, and the points that Blender draws of them, as one JSON text.

    python blender_curves.py blender-VERSION.json      with the bpy of that version (pip install bpy==4.4.0, 4.5.4, 5.0.1; Python 3.11)

Each case: the spline's type, order, whether it is cyclic, whether it has end points, whether it is in Bézier mode, how many points; `obj`, the text
of the file; `drawn`, the points of the curve that Blender evaluates.
"""
import itertools
import json
import math
import sys
import tempfile

import bpy


def point(k):
    return (math.cos(0.7 * k) * (1 + 0.2 * k), math.sin(0.7 * k) * (1 + 0.2 * k), 0.1 * k)


def clean():
    for one in list(bpy.data.objects):
        bpy.data.objects.remove(one)
    for one in list(bpy.data.curves):
        bpy.data.curves.remove(one)


def case(kind, order, cyclic, endpoint, bezier, count):
    clean()
    data = bpy.data.curves.new("c", "CURVE")
    data.dimensions = "3D"
    data.resolution_u = 4
    spline = data.splines.new(kind)
    if kind == "BEZIER":
        spline.bezier_points.add(count - 1)
        for k, p in enumerate(spline.bezier_points):
            p.co = point(k)
            p.handle_left_type = p.handle_right_type = "AUTO"
    else:
        spline.points.add(count - 1)
        for k, p in enumerate(spline.points):
            p.co = (*point(k), 1)
    spline.use_cyclic_u = cyclic
    if kind == "NURBS":
        spline.order_u = order
        spline.use_endpoint_u = endpoint
        spline.use_bezier_u = bezier
    spline.resolution_u = 4
    thing = bpy.data.objects.new("c", data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.update()
    with tempfile.NamedTemporaryFile(suffix=".obj") as file:
        bpy.ops.wm.obj_export(filepath=file.name, export_selected_objects=False, export_materials=False,
                              export_curves_as_nurbs=True, forward_axis="Y", up_axis="Z", apply_modifiers=False)
        text = open(file.name).read()
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = thing.evaluated_get(graph).to_mesh()
    drawn = [[round(x, 4) for x in v.co] for v in mesh.vertices] if mesh else []
    text = "\n".join(line for line in text.splitlines() if not line.startswith(("#", "mtllib")))
    return {"type": kind, "order": order, "cyclic": cyclic, "endpoint": endpoint, "bezier": bezier, "points": count,
            "obj": text, "drawn": drawn}


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cases = [case(kind, 0, cyclic, False, False, 4) for kind in ("POLY", "BEZIER") for cyclic in (False, True)]
    for order, cyclic, endpoint, bezier in itertools.product((2, 3, 4, 5, 6), (False, True), (False, True), (False, True)):
        for count in (order, 7):
            cases.append(case("NURBS", order, cyclic, endpoint, bezier, count))
    lines = ",\n".join(json.dumps(one, separators=(",", ":")) for one in cases)
    with open(sys.argv[1], "w") as file:
        file.write(f'{{"blender":"{bpy.app.version_string}","cases":[\n{lines}\n]}}\n')


main()
