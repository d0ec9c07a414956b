"""Golden fits by scipy: `python fits.py > fits.json`. scipy 1.17.1, numpy 2."""

import json

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline, make_lsq_spline

golden = {"interpolation": [], "least_squares": []}


def sites(n, seed):
    """Uneven, increasing, 0 to 1: no random numbers."""
    steps = 1 + 0.7 * np.sin(seed + 2.3 * np.arange(n - 1))
    ends = np.r_[0, np.cumsum(steps)]
    return ends / ends[-1]


def data(u):
    return np.c_[np.cos(5 * u) * (1 + u), np.sin(7 * u), u * u - 0.3 * np.sin(11 * u)]


def add(ends, degree, u, q, spline, **more):
    at = np.linspace(u[0], u[-1], 23)
    golden["interpolation"].append(
        dict(ends=ends, degree=degree, parameters=u.tolist(), points=q[: len(u)].tolist(), at=at.tolist(),
             values=spline(at).tolist(), second=spline.derivative(2)(at).tolist() if degree > 2 else None, **more))


for degree in range(1, 8):
    u = sites(degree + 9, degree)
    add("not-a-knot", degree, u, data(u), make_interp_spline(u, data(u), k=degree))
for degree in (2, 3, 4, 5):
    u = sites(14, degree + 0.5)
    p, n = degree, len(u)
    t = np.r_[[u[0]] * (p + 1), [u[j:j + p].mean() for j in range(1, n - p)], [u[-1]] * (p + 1)]
    add("averaged", degree, u, data(u), make_interp_spline(u, data(u), k=p, t=t))
for degree in (3, 5):
    u = sites(12, degree)
    zero = [(k, np.zeros(3)) for k in range((degree + 1) // 2, degree)]
    add("natural", degree, u, data(u), make_interp_spline(u, data(u), k=degree, bc_type=(zero, zero)))
u = sites(11, 4)
start, end = np.array([1.0, 7.0, -3.0]), np.array([0.5, -2.0, 4.0])
add("derivatives", 3, u, data(u), make_interp_spline(u, data(u), k=3, bc_type=([(1, start)], [(1, end)])),
    start=[start.tolist()], end=[end.tolist()])
for n, seed in ((9, 1), (14, 2), (40, 3)):
    u = sites(n, seed)
    q = np.c_[np.cos(2 * np.pi * u) + 0.2 * np.sin(6 * np.pi * u), np.sin(2 * np.pi * u), np.cos(4 * np.pi * u)]
    q[-1] = q[0]
    add("closed", 3, u, q[:-1], CubicSpline(u, q, bc_type="periodic"))
    golden["interpolation"][-1]["parameters"] = u.tolist()

for degree in (1, 2, 3, 5):
    u = sites(60, degree)
    q = data(u) + 0.05 * np.c_[np.sin(91 * u), np.cos(83 * u), np.sin(77 * u)]
    knots = np.r_[[0] * (degree + 1), 0.15, 0.3, 0.42, 0.6, 0.61, 0.83, [1] * (degree + 1)]
    weights = 1 + 0.9 * np.cos(13 * u)
    for w in (None, weights):
        spline = make_lsq_spline(u, q, knots, k=degree, w=None if w is None else np.sqrt(w))
        golden["least_squares"].append(
            dict(degree=degree, knots=knots.tolist(), parameters=u.tolist(), points=q.tolist(),
                 weights=None if w is None else w.tolist(), vertices=spline.c.tolist()))

print(json.dumps(golden))
