#!/usr/bin/env python3
"""Import files with real Blender (the `bpy` wheel, no window) and report what Blender sees.

    $LOFTSMAN_ORACLES/blender/bin/python blender_report.py FILE... [--render OUT.png] [--samples N]
                                    [--validate] [--max-points N] [--eval] [--frames F,F,...] [--frame-points]

FILE: .glb .gltf .obj .stl .ply .usd/.usda/.usdc/.usdz .svg .fbx .abc
stdout: one JSON object for each file, one after another; each file is imported into an empty scene (one launch
        for many files: starting Blender takes longer than most imports).  Blender's own chatter goes to stderr.
exit:   0 every file imported at least one object; 1 one did not load (its JSON has "error"); 2 bad usage.

All coordinates are Blender world coordinates (Z up) unless the key says `local`.
`--render` draws the imported objects with Cycles on the CPU (no display or GPU needed).
`--eval` adds the polyline Blender evaluates for each curve (an oracle for NURBS evaluation).
`--frames` adds where the drawn geometry is at those animation frames; without it the object reports hold
Blender's frame after import (usually 1) and meshes without their shape keys. `--frame-points` lists all points there,
and says how smooth meshes are drawn.
"""
import argparse
import json
import math
import os
import sys
import time

# Importers print to the C-level stdout.  Keep the real one for the report and send the rest to stderr.
_report_fd = os.dup(1)
os.dup2(2, 1)

import bpy  # noqa: E402
import bmesh  # noqa: E402
from mathutils import Vector  # noqa: E402

IMPORTERS = {
    ".glb": lambda p: bpy.ops.import_scene.gltf(filepath=p),
    ".gltf": lambda p: bpy.ops.import_scene.gltf(filepath=p),
    ".obj": lambda p: bpy.ops.wm.obj_import(filepath=p),
    ".stl": lambda p: bpy.ops.wm.stl_import(filepath=p),
    ".ply": lambda p: bpy.ops.wm.ply_import(filepath=p),
    ".usd": lambda p: bpy.ops.wm.usd_import(filepath=p),
    ".usda": lambda p: bpy.ops.wm.usd_import(filepath=p),
    ".usdc": lambda p: bpy.ops.wm.usd_import(filepath=p),
    ".usdz": lambda p: bpy.ops.wm.usd_import(filepath=p),
    ".svg": lambda p: bpy.ops.import_curve.svg(filepath=p),
    ".fbx": lambda p: bpy.ops.wm.fbx_import(filepath=p),
    ".abc": lambda p: bpy.ops.wm.alembic_import(filepath=p),
}


def nums(seq, digits=7):
    """A vector as a list of plain floats, rounded past single-precision noise."""
    return [round(float(x), digits) for x in seq]


def json_value(value):
    """A custom-property value as something JSON can hold."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if hasattr(value, "to_list"):
        return value.to_list()
    if isinstance(value, (bool, int, float, str)) or value is None:
        return value
    try:
        return [json_value(v) for v in value]
    except TypeError:
        return str(value)


def custom_properties(id_block):
    """User-made properties (glTF `extras`, USD attributes ...) of any Blender data block."""
    return {k: json_value(id_block[k]) for k in id_block.keys() if not k.startswith("cycles")}


def bounds(points):
    """[[min], [max]] of an iterable of 3-vectors, or None for none."""
    points = list(points)
    if not points:
        return None
    return [nums(min(p[i] for p in points) for i in range(3)),
            nums(max(p[i] for p in points) for i in range(3))]


def material_report(material):
    """Name and the inputs of the Principled shader that file formats carry."""
    if material is None:
        return None
    out = {"name": material.name, "viewport_colour": nums(material.diffuse_color, 5),
           "backface_culling": material.use_backface_culling, "extras": custom_properties(material)}
    tree = material.node_tree
    if tree is not None:
        out["shader_nodes"] = sorted({n.type for n in tree.nodes})
        shader = next((n for n in tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
        if shader is not None:
            for key, socket in (("base_colour", "Base Color"), ("metallic", "Metallic"),
                                ("roughness", "Roughness"), ("alpha", "Alpha"),
                                ("emission", "Emission Color"),
                                ("emission_strength", "Emission Strength"), ("ior", "IOR"),
                                ("transmission", "Transmission Weight"), ("coat", "Coat Weight"),
                                ("sheen", "Sheen Weight"),
                                ("anisotropic", "Anisotropic")):
                found = shader.inputs.get(socket)
                if found is not None:
                    value = found.default_value
                    out[key] = nums(value, 5) if hasattr(value, "__len__") else round(value, 5)
                    if found.is_linked:
                        out[key + "_linked_to"] = found.links[0].from_node.type
    return out


def mesh_report(obj, validate=False):
    """Topology and size of a mesh object, in world space."""
    mesh = obj.data
    out = {"vertices": len(mesh.vertices), "edges": len(mesh.edges), "faces": len(mesh.polygons)}
    if validate:
        out["blender_had_to_repair"] = bool(mesh.copy().validate(verbose=True))
    sizes = {}
    for polygon in mesh.polygons:
        sizes[polygon.loop_total] = sizes.get(polygon.loop_total, 0) + 1
    out["face_sizes"] = {str(k): sizes[k] for k in sorted(sizes)}
    out["smooth_faces"] = sum(1 for p in mesh.polygons if p.use_smooth)

    bm = bmesh.new()
    bm.from_mesh(mesh)
    bm.transform(obj.matrix_world)
    if obj.matrix_world.determinant() < 0:
        bmesh.ops.reverse_faces(bm, faces=bm.faces)
    topo = {"boundary_edges": 0, "wire_edges": 0, "overfull_edges": 0, "flipped_edges": 0}
    for edge in bm.edges:
        count = len(edge.link_faces)
        if count == 0:
            topo["wire_edges"] += 1
        elif count == 1:
            topo["boundary_edges"] += 1
        elif count > 2:
            topo["overfull_edges"] += 1
        elif not edge.is_contiguous:
            topo["flipped_edges"] += 1
    topo["loose_vertices"] = sum(1 for v in bm.verts if not v.link_edges)
    topo["non_manifold_vertices"] = sum(1 for v in bm.verts if not v.is_manifold)
    topo["components"] = component_count(bm)
    topo["euler"] = len(bm.verts) - len(bm.edges) + len(bm.faces)
    out.update(topo)
    has_faces = len(bm.faces) > 0
    out["is_manifold"] = has_faces and not (
        topo["wire_edges"] or topo["overfull_edges"] or topo["loose_vertices"])
    out["watertight"] = (has_faces and out["is_manifold"] and not topo["boundary_edges"]
                         and not topo["flipped_edges"])
    out["area"] = sum(f.calc_area() for f in bm.faces)
    out["degenerate_faces"] = sum(1 for f in bm.faces if f.calc_area() < 1e-12)
    out["volume_signed"] = bm.calc_volume(signed=True) if has_faces else 0.0
    out["wire_length"] = sum(e.calc_length() for e in bm.edges if not e.link_faces)

    # The same count after joining vertices at equal positions: glTF, STL and UV seams split them.
    before = len(bm.verts)
    bmesh.ops.remove_doubles(bm, verts=bm.verts, dist=1e-6)
    welded_ok = has_faces and all(len(e.link_faces) == 2 and e.is_contiguous for e in bm.edges)
    out["welded_at_1e-6"] = {"merged_vertices": before - len(bm.verts), "watertight": welded_ok,
                             "volume_signed": bm.calc_volume(signed=True) if has_faces else 0.0,
                             "boundary_edges": sum(1 for e in bm.edges if len(e.link_faces) == 1),
                             "components": component_count(bm),
                             "euler": len(bm.verts) - len(bm.edges) + len(bm.faces)}
    bm.free()

    used = {}
    for polygon in mesh.polygons:
        used[polygon.material_index] = used.get(polygon.material_index, 0) + 1
    out["faces_per_material_slot"] = {str(k): used[k] for k in sorted(used)}
    out["materials"] = [m.name if m else None for m in mesh.materials]
    out["uv_layers"] = []
    for layer in mesh.uv_layers:
        us = [layer.uv[i].vector for i in range(len(layer.uv))]
        out["uv_layers"].append({"name": layer.name, "range": [
            nums((min(u[0] for u in us), min(u[1] for u in us))),
            nums((max(u[0] for u in us), max(u[1] for u in us)))] if us else None})
    out["attributes"] = [{"name": a.name, "type": a.data_type, "domain": a.domain}
                         for a in mesh.attributes if not a.name.startswith(".")]
    out["custom_normals"] = mesh.has_custom_normals
    if has_faces:
        normals = mesh.corner_normals
        worst, facing_away = 0.0, 0
        for polygon in mesh.polygons:
            if polygon.area < 1e-12:
                continue
            for corner in polygon.loop_indices:
                cosine = max(-1.0, min(1.0, normals[corner].vector.dot(polygon.normal)))
                worst = max(worst, math.degrees(math.acos(cosine)))
                facing_away += cosine < 0
        out["corner_normals"] = {"max_degrees_from_face": round(worst, 4),
                                 "corners_facing_away": facing_away}
    keys = mesh.shape_keys
    if keys is not None:
        base = keys.reference_key.data
        out["shape_keys"] = [{"name": k.name, "value": round(k.value, 6), "max_shift": max(
            ((k.data[i].co - base[i].co).length for i in range(len(base))), default=0.0)}
            for k in keys.key_blocks]
    return out


def component_count(bm):
    """Pieces joined by edges (loose vertices count one each)."""
    seen, count = set(), 0
    for start in bm.verts:
        if start in seen:
            continue
        count += 1
        seen.add(start)
        stack = [start]
        while stack:
            vert = stack.pop()
            for edge in vert.link_edges:
                other = edge.other_vert(vert)
                if other not in seen:
                    seen.add(other)
                    stack.append(other)
    return count


def spline_report(spline, matrix, limit):
    """One spline of a CURVE or SURFACE object, control points in world space."""
    out = {"type": spline.type, "cyclic_u": spline.use_cyclic_u, "resolution_u": spline.resolution_u,
           "material_slot": spline.material_index}
    if spline.type == "BEZIER":
        points = spline.bezier_points
        out["points"] = len(points)
        out["local_length"] = spline.calc_length()
        out["control"] = [{"co": nums(matrix @ p.co), "left": nums(matrix @ p.handle_left),
                           "right": nums(matrix @ p.handle_right),
                           "handles": [p.handle_left_type, p.handle_right_type]}
                          for p in list(points)[:limit]]
        return out
    points = spline.points
    out["points"] = len(points)
    if spline.type == "NURBS":
        out.update(order_u=spline.order_u, endpoint_u=spline.use_endpoint_u,
                   bezier_u=spline.use_bezier_u)
        if spline.point_count_v > 1:
            out.update(order_v=spline.order_v, endpoint_v=spline.use_endpoint_v,
                       bezier_v=spline.use_bezier_v, cyclic_v=spline.use_cyclic_v,
                       count_u=spline.point_count_u, count_v=spline.point_count_v)
    out["control"] = [nums(matrix @ Vector(p.co[:3])) for p in list(points)[:limit]]
    out["weights"] = nums([p.co[3] for p in list(points)[:limit]])
    return out


def curve_report(obj, limit, evaluate):
    """A CURVE or SURFACE object; with `evaluate`, also the geometry Blender draws for it."""
    data = obj.data
    out = {"dimensions": data.dimensions, "bevel_depth": data.bevel_depth,
           "fill_mode": data.fill_mode,
           "materials": [m.name if m else None for m in data.materials],
           "splines": [spline_report(s, obj.matrix_world, limit) for s in data.splines]}
    out["evaluated"] = evaluated_report(obj, evaluate)
    return out


def evaluated_report(obj, with_points):
    """What Blender draws for a curve object; `with_points` lists the sampled polyline."""
    seen = drawn(obj)
    if seen is None:
        return {"error": "Blender makes no mesh of it"}
    points, edges, faces, local_area = seen
    out = {"vertices": len(points), "edges": len(edges), "faces": faces, "bbox": bounds(points),
           "local_area": local_area,
           "edge_length": sum((points[a] - points[b]).length for a, b in edges)}
    if with_points:
        out["points"] = [nums(p) for p in points]
    return out


def curves_report(obj, limit, evaluate):
    """The newer CURVES type (hair curves), which USD and Alembic curves may become."""
    data = obj.data
    attributes = [{"name": a.name, "type": a.data_type, "domain": a.domain}
                  for a in data.attributes]
    positions = [nums(obj.matrix_world @ p.position) for p in list(data.points)[:limit]]
    out = {"curves": len(data.curves), "points": len(data.points), "attributes": attributes,
           "points_per_curve": [c.points_length for c in data.curves][:limit], "control": positions}
    for name in ("curve_type", "cyclic", "nurbs_order", "knots_mode", "nurbs_weight"):
        found = data.attributes.get(name)
        if found is not None:
            out[name] = [json_value(v.value) for v in list(found.data)[:limit]]
    out["materials"] = [m.name if m else None for m in data.materials]
    out["evaluated"] = evaluated_report(obj, evaluate)
    return out


def action_report(action):
    """Name, length and channels of an action, for layered (4.4+) and flat actions."""
    channels = []
    if hasattr(action, "layers"):
        for layer in action.layers:
            for strip in layer.strips:
                for bag in getattr(strip, "channelbags", []):
                    channels += [(bag.slot.identifier, c) for c in bag.fcurves]
    else:
        channels = [("", c) for c in action.fcurves]
    return {"name": action.name, "frame_range": nums(action.frame_range), "fcurves": [
        {"slot": slot, "path": c.data_path, "index": c.array_index, "keys": len(c.keyframe_points),
         "interpolation": sorted({k.interpolation for k in c.keyframe_points})}
        for slot, c in channels[:64]], "fcurve_count": len(channels)}


def drawn(obj):
    """What Blender draws for an object now (shape keys, modifiers, curve evaluation), in world space.

    (points, edges, face count, area), or None where Blender draws no mesh.
    """
    if obj.type not in ("MESH", "CURVE", "SURFACE", "CURVES"):
        return None
    modifier = None
    if obj.type == "CURVES":  # the newer curves type gives a mesh only through geometry nodes
        modifier = obj.modifiers.new("report-curve-to-mesh", "NODES")
        modifier.node_group = curve_to_mesh_nodes()
        bpy.context.view_layer.update()
    held = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    try:
        geometry = None if modifier is None else held.evaluated_geometry()  # must outlive its mesh
        mesh = held.to_mesh() if geometry is None else geometry.mesh
        if mesh is None:
            return None
        return ([obj.matrix_world @ v.co for v in mesh.vertices], [tuple(e.vertices) for e in mesh.edges],
                len(mesh.polygons), sum(p.area for p in mesh.polygons))
    except RuntimeError:
        return None
    finally:
        if modifier is None:
            held.to_mesh_clear()
        else:
            obj.modifiers.remove(modifier)


def curve_to_mesh_nodes():
    """A node group that turns curves into their evaluated polylines."""
    name = "report-curve-to-mesh"
    group = bpy.data.node_groups.get(name)
    if group is None:
        group = bpy.data.node_groups.new(name, "GeometryNodeTree")
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        source, sink = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        change = group.nodes.new("GeometryNodeCurveToMesh")
        group.links.new(source.outputs[0], change.inputs[0])
        group.links.new(change.outputs[0], sink.inputs[0])
    return group


def smoothness(obj):
    """How a mesh is shaded now: faces that are smooth, and the largest angle between normals that meet at a point."""
    held = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = held.to_mesh()
    try:
        met, apart, smooth = {}, 0.0, 0
        for polygon in mesh.polygons:
            smooth += polygon.use_smooth
            for corner in polygon.loop_indices:
                normal = mesh.corner_normals[corner].vector.copy()
                first = met.setdefault(mesh.loops[corner].vertex_index, normal)
                apart = max(apart, math.degrees(first.angle(normal, 0.0)))
        return {"faces": len(mesh.polygons), "smooth_faces": smooth, "max_degrees_apart": round(apart, 4)}
    finally:
        held.to_mesh_clear()


def frame_report(frame, with_points):
    """Where every object's drawn geometry is at one frame of the animation."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    out = {"frame": frame, "objects": {}}
    for obj in bpy.context.scene.objects:
        entry = {"matrix_world": [nums(row) for row in obj.matrix_world],
                 "hidden": obj.hide_viewport or obj.hide_get()}
        seen = drawn(obj)
        if seen is not None:
            entry["bbox"], entry["vertices"] = bounds(seen[0]), len(seen[0])
            if with_points:
                entry["points"] = [nums(p, 9) for p in seen[0]]
                if obj.type == "MESH":
                    entry["shading"] = smoothness(obj)
        out["objects"][obj.name] = entry
    return out


def object_report(obj, args):
    out = {"name": obj.name, "type": obj.type, "parent": obj.parent.name if obj.parent else None,
           "collections": [c.name for c in obj.users_collection],
           "data_name": obj.data.name if obj.data else None,
           "location_local": nums(obj.location), "scale_local": nums(obj.scale),
           "matrix_world": [nums(row) for row in obj.matrix_world],
           "extras": custom_properties(obj)}
    if obj.data is not None:
        out["data_extras"] = custom_properties(obj.data)
    if obj.type == "MESH":
        out["bbox"] = bounds(obj.matrix_world @ v.co for v in obj.data.vertices)
        out.update(mesh_report(obj, args.validate))
    elif obj.type in ("CURVE", "SURFACE"):
        out["bbox"] = bounds(obj.matrix_world @ Vector(c) for c in obj.bound_box)
        out.update(curve_report(obj, args.max_points, args.eval))
    elif obj.type == "CURVES":
        out["bbox"] = bounds(obj.matrix_world @ p.position for p in obj.data.points)
        out.update(curves_report(obj, args.max_points, args.eval))
    elif obj.type == "POINTCLOUD":
        position = obj.data.attributes["position"].data
        out["bbox"] = bounds(obj.matrix_world @ p.vector for p in position)
        out["points"] = len(position)
    modifiers = [m.type for m in obj.modifiers]
    if modifiers:
        out["modifiers"] = modifiers
    return out


def render(path, samples, size=(480, 360)):
    """A three-quarter view of everything in the scene with Cycles on the CPU."""
    scene = bpy.context.scene
    corners = [obj.matrix_world @ Vector(c) for obj in scene.objects
               if obj.type in ("MESH", "CURVE", "SURFACE", "CURVES", "POINTCLOUD") for c in obj.bound_box]
    if not corners:
        raise RuntimeError("nothing to draw")
    low = Vector([min(c[i] for c in corners) for i in range(3)])
    high = Vector([max(c[i] for c in corners) for i in range(3)])
    centre, radius = (low + high) / 2, max((high - low).length / 2, 1e-6)
    thickness = radius * 0.008
    ink = bpy.data.materials.new("report-ink")
    ink.diffuse_color = (0.02, 0.05, 0.2, 1)
    if ink.node_tree is not None and "Principled BSDF" in ink.node_tree.nodes:
        ink.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.02, 0.05, 0.2, 1)
    for obj in list(scene.objects):  # lines have no faces: give them a round section to be seen
        if obj.type == "CURVE" and obj.data.bevel_depth == 0:
            obj.data.fill_mode = "FULL" if obj.data.dimensions == "3D" else "NONE"
            obj.data.bevel_depth = thickness / max(obj.matrix_world.median_scale, 1e-9)
        elif obj.type == "MESH" and obj.data.edges and not obj.data.polygons:
            with bpy.context.temp_override(active_object=obj, object=obj, selected_objects=[obj],
                                           selected_editable_objects=[obj]):
                bpy.ops.object.convert(target="CURVE")
            obj.data.bevel_depth = thickness / max(obj.matrix_world.median_scale, 1e-9)
        elif obj.type == "CURVES":
            radii = obj.data.attributes.get("radius") or obj.data.attributes.new("radius", "FLOAT", "POINT")
            for point in radii.data:
                point.value = thickness / max(obj.matrix_world.median_scale, 1e-9)
        if obj.type in ("CURVE", "CURVES") and not obj.data.materials:
            obj.data.materials.append(ink)
    flat = (high - low).z < radius * 1e-3
    direction = Vector((0, 0, 1)) if flat else Vector((1.0, -1.6, 1.1)).normalized()
    camera = bpy.data.objects.new("report-camera", bpy.data.cameras.new("report-camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 2.2 * radius * size[0] / size[1]
    camera.data.clip_start, camera.data.clip_end = radius * 0.01, radius * 20
    camera.location = centre + direction * radius * 5
    camera.rotation_euler = (0, 0, 0) if flat else direction.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    for name, toward, energy in (("key", (1.2, -0.8, 1.6), 2.0), ("fill", (-1.5, -0.6, 0.5), 0.6)):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "SUN"))
        lamp.data.energy = energy
        lamp.rotation_euler = Vector(toward).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    world = bpy.data.worlds.new("report-world")
    world.color = (0.35, 0.37, 0.4)
    scene.world = world
    if world.node_tree is not None and "Background" in world.node_tree.nodes:
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.35, 0.37, 0.4, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def report_on(file, args):
    """The report on one file, imported into an empty scene."""
    report = {"tool": "Blender " + bpy.app.version_string, "file": file}
    started = time.time()
    try:
        importer = IMPORTERS.get(os.path.splitext(file)[1].lower())
        if importer is None:
            raise RuntimeError("Blender has no importer for this file type")
        if not os.path.isfile(file):
            raise RuntimeError("no such file")
        bpy.ops.wm.read_factory_settings(use_empty=True)
        result = importer(os.path.abspath(file))
        if "FINISHED" not in result:
            raise RuntimeError("importer answered %s" % sorted(result))
        bpy.context.view_layer.update()
        scene = bpy.context.scene
        report["import_seconds"] = round(time.time() - started, 3)
        report["objects"] = [object_report(o, args) for o in scene.objects]
        kinds = {}
        for obj in scene.objects:
            kinds[obj.type] = kinds.get(obj.type, 0) + 1
        report["object_kinds"] = kinds
        if args.frames:
            report["frames"] = [frame_report(float(f), args.frame_points) for f in args.frames.split(",")]
        report["materials"] = [material_report(m) for m in bpy.data.materials]
        report["images"] = [{"name": i.name, "size": list(i.size)} for i in bpy.data.images]
        report["actions"] = [action_report(a) for a in bpy.data.actions]
        report["scene"] = {"name": scene.name, "frame_start": scene.frame_start,
                           "frame_end": scene.frame_end, "fps": scene.render.fps,
                           "extras": custom_properties(scene),
                           "unit_scale": scene.unit_settings.scale_length}
        if not scene.objects:
            raise RuntimeError("imported no objects")
        if args.render and file == args.files[-1]:
            render_started = time.time()
            render(args.render, args.samples)
            report["render"] = args.render
            report["render_seconds"] = round(time.time() - render_started, 3)
    except Exception as problem:  # noqa: BLE001 - any failure is this report's answer
        report["error"] = "%s: %s" % (type(problem).__name__, problem)
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--render", metavar="OUT.png", help="of the last file")
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--validate", action="store_true", help="run Blender's mesh repair on a copy")
    parser.add_argument("--max-points", type=int, default=200)
    parser.add_argument("--frame-points", action="store_true", help="list the points at these frames")
    parser.add_argument("--frames", metavar="F,F,...", help="also report drawn bounds at these frames")
    parser.add_argument("--eval", action="store_true", help="list evaluated curve points")
    args = parser.parse_args()
    failed = False
    for file in args.files:
        report = report_on(file, args)
        failed = failed or "error" in report
        text = (json.dumps(report, indent=1) + "\n").encode()
        while text:
            text = text[os.write(_report_fd, text):]
    sys.stdout.flush()
    # Leave without Blender's teardown, which can crash after the answer is out.
    os._exit(1 if failed else 0)


if __name__ == "__main__":
    main()
