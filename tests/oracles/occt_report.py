#!/usr/bin/env python3
"""Read a STEP or IGES file with real OpenCASCADE (the `cadquery-ocp` wheel) and report what it finds.

    $LOFTSMAN_ORACLES/python/bin/python occt_report.py FILE

stdout: one JSON object.  OpenCASCADE's own chatter goes to stderr.
exit:   0 a shape came out; 1 did not load (the JSON then has "error").

Lengths are in millimetres, whatever the file's unit.  Areas and volumes are integrated to 1e-9: what
OpenCASCADE does by default depends on how a surface is parametrised.

Behind FILE may stand
  --assembled  of an IGES file also how many solids the reader of assemblies with names and colours shows
  --colors     of a STEP file nothing but how many triangles of faces have which colour (linear red, green, blue), as its reader of
               assemblies with names and colours says
  --curves     also what its edges without faces are (the kind of curve, its length, where it starts and ends, its sizes), and what its
               faces are (the kind of surface, its area, its sizes)
  --meshed     also the volume of OpenCASCADE's own triangles, 1e-4 of the size from the faces: its integration of rational
               faces can be off by some hundredths, whatever it is asked for
"""
import json
import os
import sys

_report_fd = os.dup(1)
os.dup2(2, 1)

from OCP.Bnd import Bnd_Box  # noqa: E402
from OCP.BRepBndLib import BRepBndLib  # noqa: E402
from OCP.BRepCheck import BRepCheck_Analyzer  # noqa: E402
from OCP.BRepGProp import BRepGProp  # noqa: E402
from OCP.GProp import GProp_GProps  # noqa: E402
from OCP.IFSelect import IFSelect_ReturnStatus  # noqa: E402
from OCP.IGESControl import IGESControl_Reader  # noqa: E402
from OCP.Interface import Interface_Static  # noqa: E402
from OCP.STEPControl import STEPControl_Reader  # noqa: E402
from OCP.TopAbs import TopAbs_ShapeEnum  # noqa: E402
from OCP.TopExp import TopExp_Explorer  # noqa: E402

KINDS = {"solid": TopAbs_ShapeEnum.TopAbs_SOLID, "shell": TopAbs_ShapeEnum.TopAbs_SHELL,
         "face": TopAbs_ShapeEnum.TopAbs_FACE, "edge": TopAbs_ShapeEnum.TopAbs_EDGE}


def found(shape, kind, without=TopAbs_ShapeEnum.TopAbs_SHAPE):
    walk, some = TopExp_Explorer(shape, KINDS[kind], without), []
    while walk.More():
        some.append(walk.Current())
        walk.Next()
    return some


def mass(function, shape):
    properties = GProp_GProps()
    function(shape, properties, 1e-9)
    return properties.Mass()


def assembled(path):
    from OCP.collections import Sequence_TDF_Label
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.XCAFDoc import XCAFDoc_DocumentTool
    document = document_of(IGESCAFControl_Reader(), path)
    tool, labels = XCAFDoc_DocumentTool.ShapeTool_s(document.Main()), Sequence_TDF_Label()
    tool.GetFreeShapes(labels)
    return sum(len(found(tool.GetShape_s(labels.Value(k + 1)), "solid")) for k in range(labels.Length()))


def document_of(reader, path):
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    document = TDocStd_Document(TCollection_ExtendedString("loftsman"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    reader.ReadFile(path)
    reader.Transfer(document)
    return document


def colors(path):
    from OCP.BRep import BRep_Tool
    from OCP.collections import Sequence_TDF_Label
    from OCP.Quantity import Quantity_Color
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool
    reader = STEPCAFControl_Reader()
    reader.SetColorMode(True)
    document = document_of(reader, path)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    looks = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    kinds = (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen)

    def color(shape):
        known = Quantity_Color()
        for kind in kinds:
            if looks.GetColor(shape, kind, known):
                return [round(x, 6) for x in (known.Red(), known.Green(), known.Blue())]
        return None

    labels, counts = Sequence_TDF_Label(), {}
    tool.GetFreeShapes(labels)
    for k in range(labels.Length()):
        whole = tool.GetShape_s(labels.Value(k + 1))
        shells = found(whole, "shell") or [whole]
        for shell in shells:
            for face in found(shell, "face"):
                mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), TopLoc_Location())
                shown = color(face) or color(shell) or color(whole)
                key = json.dumps(shown)
                counts[key] = counts.get(key, 0) + (mesh.NbTriangles() if mesh is not None else 0)
    return [{"color": json.loads(key), "triangles": count} for key, count in sorted(counts.items())]


def meshed(shape, size):
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    BRepMesh_IncrementalMesh(shape, 1e-4 * size, False, 0.1, False)
    total = 0.0
    for face in found(shape, "face"):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), location)
        if mesh is None:
            return None
        points = [mesh.Node(k + 1).Transformed(location.Transformation()) for k in range(mesh.NbNodes())]
        turn = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
        for k in range(mesh.NbTriangles()):
            a, b, c = (points[n - 1] for n in mesh.Triangle(k + 1).Get()[-3:])
            cross = (b.Y() * c.Z() - b.Z() * c.Y(), b.Z() * c.X() - b.X() * c.Z(), b.X() * c.Y() - b.Y() * c.X())
            total += turn * (a.X() * cross[0] + a.Y() * cross[1] + a.Z() * cross[2]) / 6.0
    return total


def curves(shape):
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_AbscissaPoint
    from OCP.GeomAbs import GeomAbs_CurveType as Kind
    from OCP.TopoDS import TopoDS
    sizes = {Kind.GeomAbs_Circle: lambda c: [c.Circle().Radius()],
             Kind.GeomAbs_Ellipse: lambda c: [c.Ellipse().MajorRadius(), c.Ellipse().MinorRadius()],
             Kind.GeomAbs_Parabola: lambda c: [c.Parabola().Focal()],
             Kind.GeomAbs_Hyperbola: lambda c: [c.Hyperbola().MajorRadius(), c.Hyperbola().MinorRadius()]}
    some = []
    for edge in found(shape, "edge", KINDS["face"]):
        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        ends = [curve.Value(t) for t in (curve.FirstParameter(), curve.LastParameter())]
        middle = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
        some.append({"kind": str(curve.GetType()).split("_")[-1].lower(),
                     "length": GCPnts_AbscissaPoint.Length_s(curve, 1e-12),
                     "places": [[p.X(), p.Y(), p.Z()] for p in [ends[0], middle, ends[1]]],
                     "sizes": sizes.get(curve.GetType(), lambda c: [])(curve)})
    return some


def surfaces(shape):
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_SurfaceType as Kind
    from OCP.TopoDS import TopoDS
    sizes = {Kind.GeomAbs_Cylinder: lambda s: [s.Cylinder().Radius()],
             Kind.GeomAbs_Cone: lambda s: [s.Cone().SemiAngle()],
             Kind.GeomAbs_Sphere: lambda s: [s.Sphere().Radius()],
             Kind.GeomAbs_Torus: lambda s: [s.Torus().MajorRadius(), s.Torus().MinorRadius()]}
    some = []
    for face in found(shape, "face"):
        surface = BRepAdaptor_Surface(TopoDS.Face(face))
        some.append({"kind": str(surface.GetType()).split("_")[-1].lower(),
                     "area": mass(BRepGProp.SurfaceProperties_s, face),
                     "sizes": sizes.get(surface.GetType(), lambda s: [])(surface)})
    return some


def report(path, more=()):
    if "--colors" in more:
        return {"colors": colors(path)}
    if path.lower().endswith((".igs", ".iges")):
        reader = IGESControl_Reader()
        Interface_Static.SetIVal_s("read.iges.bspline.continuity", 0)  # or curves are cut where they have corners
    else:
        reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        return {"error": "it is not read"}
    reader.TransferRoots()
    if not reader.NbShapes():
        return {"error": "no shape comes out"}
    shape = reader.OneShape()
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    low, high = box.CornerMin(), box.CornerMax()
    answer = {"counts": {kind: len(found(shape, kind)) for kind in KINDS},
              "valid": BRepCheck_Analyzer(shape).IsValid(),
              "low": [low.X(), low.Y(), low.Z()], "high": [high.X(), high.Y(), high.Z()],
              "area": mass(BRepGProp.SurfaceProperties_s, shape),
              "volume": sum(mass(BRepGProp.VolumeProperties_s, solid) for solid in found(shape, "solid"))}
    if "--assembled" in more and isinstance(reader, IGESControl_Reader):
        answer["assembled"] = assembled(path)
    if "--curves" in more:
        answer["curves"], answer["surfaces"] = curves(shape), surfaces(shape)
    if "--meshed" in more:
        answer["meshed"] = meshed(shape, low.Distance(high))
    return answer


def main():
    answer = report(sys.argv[1], sys.argv[2:])
    answer["tool"] = "OpenCASCADE (cadquery-ocp)"
    os.write(_report_fd, (json.dumps(answer, indent=1) + "\n").encode())
    os._exit(1 if "error" in answer else 0)  # not through destructors


if __name__ == "__main__":
    main()
