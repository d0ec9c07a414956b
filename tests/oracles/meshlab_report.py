#!/usr/bin/env python3
"""Load a mesh with real MeshLab (the `pymeshlab` wheel) and report what MeshLab measures.

    $LOFTSMAN_ORACLES/python/bin/python meshlab_report.py FILE [--weld]

FILE: .obj .stl .ply .off .3mf .glb/.gltf .x3d .dae .3ds .dxf .wrl ... (whatever MeshLab imports)
stdout: one JSON object.  MeshLab's own chatter goes to stderr.
exit:   0 at least one mesh was loaded; 1 did not load (the JSON then has "error"); 2 bad usage.

`--weld` adds the same measures after merging vertices at equal positions (STL and UV seams split them).
"""
import argparse
import json
import os
import sys
import time

_report_fd = os.dup(1)
os.dup2(2, 1)

import pymeshlab  # noqa: E402


def plain(value):
    """numpy scalars and arrays as JSON values."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    return value


def measures(meshes):
    """MeshLab's two measuring filters, plus the one-word answers people want from them."""
    mesh = meshes.current_mesh()
    out = {"vertices": mesh.vertex_number(), "faces": mesh.face_number(), "edges": mesh.edge_number()}
    if mesh.vertex_number():
        box = mesh.bounding_box()
        out["bbox"] = [plain(box.min()), plain(box.max())]
    if not mesh.face_number():
        return out
    topology = meshes.get_topological_measures()
    out["topology"] = plain(topology)
    out["watertight"] = bool(topology["is_mesh_two_manifold"]) and topology["boundary_edges"] == 0
    geometry = meshes.get_geometric_measures()
    geometry.pop("bbox", None)
    out["geometry"] = plain(geometry)
    out["area"] = plain(geometry.get("surface_area"))
    out["volume"] = plain(geometry.get("mesh_volume"))  # MeshLab gives none for an open mesh
    return out


def attributes(mesh):
    out = {"label": mesh.label(), "is_point_cloud": mesh.is_point_cloud(),
           "vertex_colour": mesh.has_vertex_color(), "face_colour": mesh.has_face_color(),
           "vertex_scalar": mesh.has_vertex_scalar(), "face_scalar": mesh.has_face_scalar(),
           "vertex_texture": mesh.has_vertex_tex_coord(), "wedge_texture": mesh.has_wedge_tex_coord(),
           "textures": mesh.texture_number(), "transform": plain(mesh.transform_matrix())}
    if mesh.face_number():
        sizes = {}
        for polygon in mesh.polygonal_face_list():
            sizes[len(polygon)] = sizes.get(len(polygon), 0) + 1
        out["polygon_sizes"] = {str(k): sizes[k] for k in sorted(sizes)}
    custom = []
    for method in ("vertex_custom_scalar_attribute_array", "face_custom_scalar_attribute_array"):
        for name in ("quality", "curvature", "radius"):
            try:
                getattr(mesh, method)(name)
                custom.append([method.split("_")[0], name])
            except Exception:  # noqa: BLE001 - absent
                pass
    if custom:
        out["custom_scalars"] = custom
    if mesh.has_vertex_color() and mesh.vertex_number():
        colours = mesh.vertex_color_matrix()
        out["vertex_colour_range"] = [plain(colours.min(axis=0)), plain(colours.max(axis=0))]
    if mesh.has_vertex_scalar() and mesh.vertex_number():
        scalar = mesh.vertex_scalar_array()
        out["vertex_scalar_range"] = [float(scalar.min()), float(scalar.max())]
    return out


def guarded(work):
    """Run `work` in a child process: a crash inside native code then still gets a JSON answer."""
    child = os.fork()
    if child == 0:
        work()  # answers and leaves
        os._exit(1)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status < 0:
        answer = {"tool": "MeshLab (pymeshlab)", "error": "MeshLab crashed with signal %d" % -status}
        os.write(_report_fd, (json.dumps(answer, indent=1) + "\n").encode())
        return 1
    return status


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file")
    parser.add_argument("--weld", action="store_true")
    args = parser.parse_args()
    report = {"tool": "MeshLab (pymeshlab)", "file": args.file}
    started = time.time()
    try:
        from importlib.metadata import version
        report["tool"] = "MeshLab (pymeshlab %s)" % version("pymeshlab")
        if not os.path.isfile(args.file):
            raise RuntimeError("no such file")
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(os.path.abspath(args.file))
        report["meshes"] = []
        for number in range(len(meshes)):
            meshes.set_current_mesh(number)
            entry = attributes(meshes.current_mesh())
            entry.update(measures(meshes))
            if args.weld and meshes.current_mesh().face_number():
                meshes.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(1e-6))
                entry["welded"] = measures(meshes)
            report["meshes"].append(entry)
        if not report["meshes"]:
            raise RuntimeError("no meshes")
        if not any(m["vertices"] for m in report["meshes"]):
            raise RuntimeError("loaded, but with no vertices")
    except Exception as problem:  # noqa: BLE001 - any failure is this report's answer
        report["error"] = "%s: %s" % (type(problem).__name__, problem)
    report["seconds"] = round(time.time() - started, 3)
    os.write(_report_fd, (json.dumps(report, indent=1) + "\n").encode())
    os._exit(1 if "error" in report else 0)  # not through destructors, which can crash after the answer


if __name__ == "__main__":
    raise SystemExit(guarded(main))
