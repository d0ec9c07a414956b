#!/usr/bin/env python3
"""Makes `kernel/tests/golden/nearly_dependent.json`: positions asked for so near to one another that their equations are dependent
to rounding, and agree.

    python nearly_dependent.py > ../../kernel/tests/golden/nearly_dependent.json
    python nearly_dependent.py --check ../../kernel/tests/golden/nearly_dependent.json

A case is a periodic curve (`degree`, `knots` of one period, `points`, `weights` or null) and twelve positions: two clusters of six,
1e-13 of the period apart (`at`), each with the change that is asked of it (`by`). Changes are those of one displacement of all
control vertices, evaluated in exact rationals by Cox and de Boor's recurrence and rounded once: so all of them can be had, by that
displacement for one, and whoever calls them a conflict is wrong.

The first two curves, and the places on them, were found among thousands of random ones by a search that was not kept, because
solvers failed on them; they are written down here. The others are drawn, as those were.
"""
import json
import random
import sys
from fractions import Fraction

RANDOM = random.Random(20261)
CLUSTER = 6
APART = 1e-13
DRAWN = 22

FOUND = [
    {"degree": 4,
     "knots": [0.4779094099975492, 1.1681518013229433, 2.0923095055370817, 2.526076132067975, 3.5831951104848043,
               3.828164835534538, 4.953135252595665, 6.473150001764849, 6.884721744436614, 7.315690309764793,
               8.128648839643475],
     "points": [[1.681840776250671, -1.2567718200468352, 0.7217513047614154],
                [-0.22730112602976527, -0.7068336407059301, 0.5145795370272297],
                [-1.122921727460781, -2.0331003221810655, -0.9108171019257258],
                [0.40464656272927896, 1.454758070111829, -0.9558582793311621],
                [-0.9790402415299154, 1.1701937779631844, 2.4516045956564056],
                [0.4772765685662832, 0.09730766773099318, 0.3429433626224788],
                [0.49033886907574525, -1.1073447622674482, -0.958676668934043],
                [0.23571846193547694, -1.05188670304875, 0.5885283428326887],
                [0.9824510009552633, 0.25221470200237206, 2.3053084946937017],
                [-1.4856660930511298, -1.5348830903787332, 0.19286254211980539]],
     "weights": None,
     "from": [7.87648487383116, 6.0610780706202725]},
    {"degree": 4,
     "knots": [1.187927875255788, 2.9055345492132085, 4.228447717368219, 4.62540297145543, 5.782261343517939,
               6.73927787243547, 8.267618848499621, 9.39720166357428, 10.411941834016227, 12.006892475972556],
     "points": [[-1.050445990893791, 1.2972867696421317, 1.613079025104406],
                [0.43175363357178137, -0.8819856541627429, -0.5669391979314741],
                [-0.52263872423916, 1.5802684242007579, 0.42977032486541206],
                [-0.4209486584134077, 0.3385573609257352, -0.40591753211057907],
                [-0.3191948993043026, -0.09642454836058637, -0.09795225192659957],
                [-3.3070127503342173, 1.7689708239917372, 0.22333849055226987],
                [0.6163946770520445, 1.9954842342310115, -1.3377902703601598],
                [-0.011899656467183, -0.38827041573948196, -0.6445813682558665],
                [-0.0701645959373973, -1.5137675614213895, 1.594025590451958]],
     "weights": [4.431946941180875, 4.2811981251910645, 3.757672585917704, 3.345215844855362, 4.480093818549251,
                 3.01579421863661, 2.874929963241067, 1.0048670586614667, 3.068407215200069],
     "from": [7.381330674664125, 8.570385424254614]},
]


def row(curve, u):
    """The value at u of every control vertex's basis function; vertex i's B-spline has its support from knots[i] on."""
    p, knots = curve["degree"], [Fraction(k) for k in curve["knots"]]
    n, period, u = len(knots) - 1, knots[-1] - knots[0], Fraction(u)
    t = lambda k: knots[k % n] + (k // n) * period  # noqa: E731
    functions = {k: Fraction(int(t(k) <= u < t(k + 1))) for k in range(-p, n + p)}
    for d in range(1, p + 1):
        functions = {k: (u - t(k)) / (t(k + d) - t(k)) * functions[k]
                     + (t(k + d + 1) - u) / (t(k + d + 1) - t(k + 1)) * functions[k + 1]
                     for k in range(-p, n + p - d)}
    values = [Fraction(0)] * n
    for k, value in functions.items():
        values[k % n] += value
    if curve["weights"]:
        values = [v * Fraction(w) for v, w in zip(values, curve["weights"])]
        values = [v / sum(values) for v in values]
    return values


def short(low, high, digits=3):
    return round(low + (high - low) * RANDOM.random(), digits)


def vectors(count, size):
    return [[short(-size, size) for _ in range(3)] for _ in range(count)]


def drawn():
    """A random curve, and where its clusters start."""
    degree = 2 + int(4 * RANDOM.random())
    n = degree + 3 + int(6 * RANDOM.random())
    knots = [short(-2.0, 2.0)]
    for _ in range(n):
        knots.append(round(knots[-1] + short(0.2, 1.7), 3))
    weights = [short(1.0, 5.0) for _ in range(n)] if RANDOM.random() < 0.5 else None
    start, end = knots[0], knots[-1]
    places = [round(start + (end - start) * (share + 0.35 * RANDOM.random()), 4) for share in (0.05, 0.55)]
    return {"degree": degree, "knots": knots, "points": vectors(n, 3.0), "weights": weights, "from": places}


def case(curve):
    step = APART * (curve["knots"][-1] - curve["knots"][0])
    at = [u + k * step for u in curve["from"] for k in range(CLUSTER)]
    displacement = vectors(len(curve["points"]), 2.0)
    said = {key: curve[key] for key in ("degree", "knots", "points", "weights")}
    said["at"] = at
    said["by"] = [[float(sum(v * Fraction(d[axis]) for v, d in zip(values, displacement))) for axis in range(3)]
                  for values in (row(curve, u) for u in at)]
    return said


def main():
    cases = [case(curve) for curve in FOUND + [drawn() for _ in range(DRAWN)]]
    text = "[\n" + ",\n".join(json.dumps(one) for one in cases) + "\n]\n"
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        with open(sys.argv[2], encoding="utf-8") as file:
            sys.exit(0 if file.read() == text else "the file is not what this program makes")
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
