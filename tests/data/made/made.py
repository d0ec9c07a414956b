"""Writes the STEP and IGES files beside it with OpenCASCADE."""

from OCP.BRepAlgoAPI import BRepAlgoAPI_Common as common
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut as cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge as edge
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace as face
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire as wire
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox as box
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism as prism
from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol as revolved
from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere as sphere
from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus as torus
from OCP.collections import Array1_gp_Pnt
from OCP.Geom import (
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_OffsetSurface,
    Geom_Parabola,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
)
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Elips, gp_Hypr, gp_Parab, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IGESControl import IGESControl_Writer
from OCP.Quantity import Quantity_Color, Quantity_TOC_RGB
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_ExtendedString as text
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

origin, up = gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)


def write(name, shape):
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_AsIs)
    writer.Write(f"{name}.step")


def points(rows):
    array = Array1_gp_Pnt(1, len(rows))
    for k, row in enumerate(rows):
        array.SetValue(k + 1, gp_Pnt(*row))
    return array


ellipse = face(wire(edge(gp_Elips(gp_Ax2(origin, up), 3, 2)).Edge()).Wire()).Face()
write("elprism", prism(ellipse, gp_Vec(0, 0, 4)).Shape())
write("elslant", prism(ellipse, gp_Vec(1, 0, 4)).Shape())

curve = GeomAPI_PointsToBSpline(points([(3, 0, 0), (4, 0, 1), (3.5, 0, 2), (5, 0, 3)])).Curve()
corners = [gp_Pnt(5, 0, 3), gp_Pnt(2, 0, 3), gp_Pnt(2, 0, 0), gp_Pnt(3, 0, 0)]
sides = [edge(a, b).Edge() for a, b in zip(corners, corners[1:])]
profile = face(wire(edge(curve).Edge(), *sides).Wire()).Face()
write("splext", prism(profile, gp_Vec(1, 3, 0)).Shape())
write("splrev", revolved(profile, gp_Ax1(origin, up)).Shape())
write("splrevpart", revolved(profile, gp_Ax1(origin, up), 2.0).Shape())

parabola = Geom_Parabola(gp_Parab(gp_Ax2(origin, up), 1.0))
hyperbola = Geom_Hyperbola(gp_Hypr(gp_Ax2(origin, up), 2, 1.0))
for name, conic, a, b in (("parab", parabola, -2, 3), ("hyper", hyperbola, -1, 1.2)):
    chord = edge(conic.Value(b), conic.Value(a)).Edge()
    segment = face(wire(edge(conic, a, b).Edge(), chord).Wire()).Face()
    write(name, prism(segment, gp_Vec(0, 0, 2)).Shape())

extrusion = Geom_SurfaceOfLinearExtrusion(curve, gp_Dir(0, 1, 0))
offset = Geom_OffsetSurface(extrusion, 0.3)
write("offset", face(offset, curve.FirstParameter(), curve.LastParameter(), 0, 2, 1e-6).Shape())
ring = Geom_Ellipse(gp_Elips(gp_Ax2(gp_Pnt(6, 0, 0), gp_Dir(0, 1, 0)), 2, 1))
write("elrev", face(Geom_SurfaceOfRevolution(ring, gp_Ax1(origin, up)), 0, 1.5, 0, 2.0, 1e-6).Shape())

writer = IGESControl_Writer("MM", 0)
writer.AddShape(torus(5, 1).Shape())
writer.ComputeModel()
writer.Write("torus.igs")

writer = IGESControl_Writer("MM", 0)
writer.AddShape(common(sphere(2).Shape(), sphere(gp_Pnt(0, 2.2, 0.4), 1).Shape()).Shape())
writer.ComputeModel()
writer.Write("lens.igs")

write("hollow", cut(box(10, 8, 6).Shape(), sphere(gp_Pnt(5, 4, 3), 2).Shape()).Shape())

# An assembly whose occurrences have names and colours of their own.
document = TDocStd_Document(text("made"))
XCAFApp_Application.GetApplication_s().NewDocument(text("MDTV-XCAF"), document)
shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())


def called(label, name, color=None):
    TDataStd_Name.Set_s(label, text(name))
    if color is not None:
        colors.SetColor(label, Quantity_Color(*color, Quantity_TOC_RGB), XCAFDoc_ColorSurf)
    return label


def occurrence(whole, part, name, shift, color=None):
    move = gp_Trsf()
    move.SetTranslation(gp_Vec(shift, 0, 0))
    called(shapes.AddComponent(whole, part, TopLoc_Location(move)), name, color)


brick = called(shapes.AddShape(box(1, 2, 3).Shape(), False), "brick", (1, 0, 0))
bare = called(shapes.AddShape(box(1, 1, 1).Shape(), False), "bare")
pin = called(shapes.AddShape(box(0.5, 0.5, 4).Shape(), False), "pin", (0, 0, 1))
pair, wall = called(shapes.NewShape(), "pair"), called(shapes.NewShape(), "wall")
occurrence(pair, brick, "one", 0)
occurrence(pair, brick, "two", 2, (0, 0, 1))
occurrence(wall, brick, "left", 10)
occurrence(wall, brick, "right", 12, (0, 1, 0))
occurrence(wall, bare, "seen", 14, (1, 1, 0))
occurrence(wall, bare, "unseen", 16)
occurrence(wall, pin, "the only pin", 18, (0, 1, 1))
occurrence(wall, pair, "first pair", 20)
occurrence(wall, pair, "second pair", 30, (1, 1, 0))
post, frame = called(shapes.AddShape(box(1, 1, 5).Shape(), False), "post", (0, 0, 1)), called(shapes.NewShape(), "frame")
occurrence(frame, post, "the post", 0)
occurrence(frame, bare, "the cube", 3)
occurrence(wall, frame, "the frame", 40, (1, 0, 0))
shapes.UpdateAssemblies()
writer = STEPCAFControl_Writer()
writer.SetColorMode(True)
writer.SetNameMode(True)
writer.Transfer(document)
writer.Write("occurrences.step")
