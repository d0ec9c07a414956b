"""Offsets with sharp corners of wires out of lines and arcs, in closed form: lines and arcs again.

The convention is Loftsman's: at a corner that opens on the side of the offset both moved pieces are prolonged along their tangents until they meet, and what these sides
enclose with the corner, the tip, counts as nearer than the distance. (OpenCASCADE prolongs arcs as arcs.) All moved pieces and sides of tips are cut where they meet,
and of the parts those are kept that nothing of the wire is nearer to than the distance and that are in no tip. `check` holds the area of closed ones against a
union of polygons.
"""
import math

import shapely

NEAR = 1e-9


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1])


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


class Line:
    def __init__(self, a, b):
        self.a, self.b = tuple(a), tuple(b)
        self.long = math.dist(a, b)
        self.way = ((b[0] - a[0]) / self.long, (b[1] - a[1]) / self.long)

    def at(self, x):
        return (self.a[0] + (self.b[0] - self.a[0]) * x, self.a[1] + (self.b[1] - self.a[1]) * x)

    def ways(self):
        return self.way, self.way

    def moved(self, right):
        by = (right * self.way[1], -right * self.way[0])
        return Line((self.a[0] + by[0], self.a[1] + by[1]), (self.b[0] + by[0], self.b[1] + by[1]))

    def distance(self, p):
        x = sub(p, self.a)
        along = min(max(x[0] * self.way[0] + x[1] * self.way[1], 0.0), self.long)
        return math.dist(p, (self.a[0] + self.way[0] * along, self.a[1] + self.way[1] * along))

    def where(self, p):
        x = sub(p, self.a)
        return (x[0] * self.way[0] + x[1] * self.way[1]) / self.long

    def part(self, x, y):
        return Line(self.at(x), self.at(y))

    def doubled_area(self):
        return cross(self.a, self.b)

    def box(self):
        return [self.a, self.b]

    def near(self, reach):
        return shapely.LineString([self.a, self.b]).buffer(reach, quad_segs=400)


class Arc:
    def __init__(self, center, radius, first, turn):
        self.center, self.radius, self.first, self.turn = center, radius, first, turn
        self.long = radius * abs(turn)
        self.a, self.b = self.at(0.0), self.at(1.0)

    @staticmethod
    def through(p, q, r):
        ax, ay, bx, by = q[0] - p[0], q[1] - p[1], r[0] - p[0], r[1] - p[1]
        d = 2.0 * (ax * by - ay * bx)
        center = (p[0] + (by * (ax * ax + ay * ay) - ay * (bx * bx + by * by)) / d, p[1] + (ax * (bx * bx + by * by) - bx * (ax * ax + ay * ay)) / d)
        angle = [math.atan2(s[1] - center[1], s[0] - center[0]) for s in (p, r)]
        turn = (angle[1] - angle[0]) % (2 * math.pi)
        return Arc(center, math.dist(p, center), angle[0], turn if d > 0 else turn - 2 * math.pi)

    def at(self, x):
        angle = self.first + self.turn * x
        return (self.center[0] + self.radius * math.cos(angle), self.center[1] + self.radius * math.sin(angle))

    def ways(self):
        sign = math.copysign(1.0, self.turn)
        return tuple((-sign * math.sin(a), sign * math.cos(a)) for a in (self.first, self.first + self.turn))

    def moved(self, right):
        radius = self.radius + math.copysign(right, self.turn * right)
        if abs(radius) < NEAR:
            return None
        # Moved beyond its centre it runs backwards.
        return Arc(self.center, radius, self.first, self.turn) if radius > 0 else Arc(self.center, -radius, self.first + math.pi, self.turn)

    def where(self, p):
        angle = math.atan2(p[1] - self.center[1], p[0] - self.center[0])
        x = ((angle - self.first) * math.copysign(1.0, self.turn)) % (2 * math.pi) / abs(self.turn)
        whole = 2 * math.pi / abs(self.turn)
        return x - whole if x > 0.5 * (1 + whole) else x

    def distance(self, p):
        x = self.where(p)
        if 0.0 <= x <= 1.0:
            return abs(math.dist(p, self.center) - self.radius)
        return min(math.dist(p, self.a), math.dist(p, self.b))

    def part(self, x, y):
        return Arc(self.center, self.radius, self.first + self.turn * x, self.turn * (y - x))

    def doubled_area(self):
        return self.radius * self.radius * self.turn + cross(self.center, sub(self.b, self.a))

    def box(self):
        axes = ((self.center[0] + s * self.radius * (1 - k), self.center[1] + s * self.radius * k) for k in (0, 1) for s in (1, -1))
        return [self.a, self.b] + [p for p in axes if 0.0 <= self.where(p) <= 1.0]

    def near(self, reach):
        count = max(4, int(abs(self.turn) * 600))
        rim = lambda radius: [Arc(self.center, radius, self.first, self.turn).at(k / count) for k in range(count + 1)]  # noqa: E731
        inner = rim(self.radius - reach)[::-1] if reach < self.radius else [self.center]
        ends = [shapely.Point(p).buffer(reach, quad_segs=400) for p in (self.a, self.b)]
        return shapely.union_all([shapely.Polygon(rim(self.radius + reach) + inner), *ends])


def meet(one, other):
    """Where lines and circles cross."""
    if isinstance(one, Line) and isinstance(other, Line):
        area = cross(one.way, other.way)
        if abs(area) < 1e-12:
            return [other.a, other.b, one.a, one.b] if abs(cross(sub(other.a, one.a), one.way)) < NEAR else []
        return [one.at(cross(sub(other.a, one.a), other.way) / area / one.long)]
    if isinstance(one, Arc) and isinstance(other, Line):
        return meet(other, one)
    if isinstance(one, Line):
        x = sub(other.center, one.a)
        along, off = x[0] * one.way[0] + x[1] * one.way[1], abs(cross(one.way, x))
        if off > other.radius + NEAR:
            return []
        half = math.sqrt(max(other.radius**2 - off**2, 0.0))
        return [one.at((along + s * half) / one.long) for s in (1, -1)]
    far = math.dist(one.center, other.center)
    if far < NEAR:
        return [one.a, one.b, other.a, other.b] if abs(one.radius - other.radius) < NEAR else []
    along = (far * far + one.radius**2 - other.radius**2) / (2 * far)
    square = one.radius**2 - along * along
    if square < -NEAR:
        return []
    way, half = ((other.center[0] - one.center[0]) / far, (other.center[1] - one.center[1]) / far), math.sqrt(max(square, 0.0))
    return [(one.center[0] + way[0] * along - s * way[1] * half, one.center[1] + way[1] * along + s * way[0] * half) for s in (1, -1)]


class Tip:
    def __init__(self, corner, before, after, right):
        arms = [(right * w[1], -right * w[0]) for w in (before, after)]
        share = 1.0 / (1.0 + before[0] * after[0] + before[1] * after[1])
        tip = (corner[0] + (arms[0][0] + arms[1][0]) * share, corner[1] + (arms[0][1] + arms[1][1]) * share)
        ends = [(corner[0] + a[0], corner[1] + a[1]) for a in arms]
        self.sides = [Line(ends[0], tip), Line(tip, ends[1])]
        self.points = [corner, ends[0], tip, ends[1]]

    def holds(self, p):
        """Whether it is inside, by more than rounding."""
        sides = [Line(a, b) for a, b in zip(self.points, self.points[1:] + self.points[:1])]
        depths = [cross(s.way, sub(p, s.a)) for s in sides]
        return min(depths) > NEAR or max(depths) < -NEAR


def read(pieces):
    """The wire; nothing where something else than lines and arcs is in it."""
    if any("line" not in p and "arc" not in p for p in pieces):
        return None
    return [Line(*p["line"]) if "line" in p else Arc.through(*p["arc"]) for p in pieces]


def tips(wire, right, is_closed):
    found, arcs = [], False
    for one, other in zip(wire, wire[1:] + (wire[:1] if is_closed else [])):
        before, after = one.ways()[1], other.ways()[0]
        if cross(before, after) * right > 1e-6 * abs(right):
            found.append(Tip(other.a, before, after, right))
            arcs = arcs or isinstance(one, Arc) or isinstance(other, Arc)
    return found, arcs


def offset(wire, right, is_closed):
    """Runs of lines and arcs, each from its start on, and whether an arc ends at a corner that is prolonged."""
    corners, arcs = tips(wire, right, is_closed)
    candidates = [(m, None) for m in (p.moved(right) for p in wire) if m] + [(s, tip) for tip in corners for s in tip.sides]
    parts = []
    for one, own in candidates:
        cuts = {0.0, 1.0}
        others = [o for o, _ in candidates if o is not one] + [Line(a, b) for t in corners if t is not own for a, b in zip(t.points, t.points[1:] + t.points[:1])]
        for other in others:
            for p in meet(one, other):
                x, y = one.where(p), other.where(p)
                if NEAR < x < 1 - NEAR and -NEAR <= y <= 1 + NEAR:
                    cuts.add(x)
        cuts = sorted(cuts)
        for x, y in zip(cuts, cuts[1:]):
            if (y - x) * one.long < 1e-8:
                continue
            middle = one.at(0.5 * (x + y))
            if min(p.distance(middle) for p in wire) > abs(right) - NEAR and not any(t.holds(middle) for t in corners if t is not own):
                parts.append(one.part(x, y))
    runs, rest = [], parts
    while rest:
        run = [rest.pop(0)]
        while True:
            after = [p for p in rest if math.dist(p.a, run[-1].b) < 1e-7]
            before = [p for p in rest if math.dist(p.b, run[0].a) < 1e-7]
            if math.dist(run[0].a, run[-1].b) < 1e-7 or not (after or before):
                break
            piece = (after or before)[0]
            rest.remove(piece)
            run = run + [piece] if after else [piece] + run
        runs.append(run)
    return runs, arcs


def area(runs):
    return 0.5 * sum(p.doubled_area() for run in runs for p in run)


def length(runs):
    return sum(p.long for run in runs for p in run)


def check(wire, right, runs):
    """Relative difference of the area of a closed one from that of polygons: the outline, all that is near to a piece, and tips."""
    outline = shapely.Polygon([p.at(k / 200) for p in wire for k in range(200)])
    outward = (right > 0) == outline.exterior.is_ccw
    near = [p.near(abs(right)) for p in wire] + [shapely.Polygon(t.points) for t in tips(wire, right, True)[0]]
    found = shapely.union_all([outline, *near]).area if outward else shapely.difference(outline, shapely.union_all(near)).area
    return abs(abs(area(runs)) - found) / found
