"""A rod held at one end and loaded at the other, in PyElastica 1.0 (a Cosserat rod, position Verlet, uniform damping): where its tip
comes to rest under loads F L² / EI from 0.01 to 4, and how its tip swings undamped after the smallest is let go.

PyElastica holds the direction of a whole element at the end, so that a rod of n elements is too short by half of one (its tip 2.3 %
too high with 64). With 32 and 64 elements, the values for infinitely many follow (Richardson); both are kept beside them.

    python3 cantilever.py > cantilever.json      # needs pyelastica==1.0.0
"""
import json
import sys

import elastica as ea
import numpy as np

LENGTH, RADIUS, YOUNG, DENSITY = 1.0, 0.01, 1e6, 1000.0
AREA = np.pi * RADIUS**2
BENDING = YOUNG * np.pi * RADIUS**4 / 4
MASS = DENSITY * AREA
# Twice the lowest frequency would be critical damping.
LOWEST = 3.516 * np.sqrt(BENDING / MASS) / LENGTH**2


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def rod(elements):
    return ea.CosseratRod.straight_rod(
        elements, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), LENGTH, RADIUS, DENSITY,
        youngs_modulus=YOUNG, shear_modulus=YOUNG / 3,
    )


def run(elements, load, damping, seconds, watch=None, given=None):
    # A wave of stretching takes at least this long through an element; a tenth of it is stable.
    step = 0.1 * (LENGTH / elements) / np.sqrt(YOUNG / DENSITY)
    simulator, beam = Simulator(), rod(elements)
    if given is not None:
        for name in ("position_collection", "director_collection"):
            getattr(beam, name)[:] = given[name]
    simulator.append(beam)
    simulator.constrain(beam).using(
        ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    if load:
        simulator.add_forcing_to(beam).using(
            ea.EndpointForces, np.zeros(3), np.array([0, 0, -load]), ramp_up_time=1.0
        )
    if damping:
        simulator.dampen(beam).using(ea.AnalyticalLinearDamper, uniform_damping_constant=damping, time_step=step)
    simulator.finalize()
    stepper, time = ea.PositionVerlet(), np.float64(0.0)
    for k in range(int(seconds / step)):
        time = stepper.step(simulator, time, np.float64(step))
        if watch is not None:
            watch(time, beam.position_collection[2, -1])
    return beam


def tips(elements):
    at, bent = [], None
    for share in (0.01, 0.5, 1.0, 2.0, 4.0):
        beam = run(elements, share * BENDING / LENGTH**2, 2 * LOWEST, 1.0 + 20 / LOWEST)
        assert np.abs(beam.velocity_collection).max() < 1e-8, "it rests"
        at.append(beam.position_collection[:, -1].tolist())
        if bent is None:
            bent = {name: getattr(beam, name).copy() for name in ("position_collection", "director_collection")}
    heights = []
    run(elements, 0, 0, 2.2 * 2 * np.pi / LOWEST, lambda time, z: heights.append((time, z)), bent)
    ups = [a[0] + (b[0] - a[0]) * a[1] / (a[1] - b[1]) for a, b in zip(heights, heights[1:]) if a[1] < 0 <= b[1]]
    return np.array(at), ups[1] - ups[0]


def main():
    (coarse, slow), (fine, fast) = tips(32), tips(64)
    out = {"length": LENGTH, "bending": BENDING, "stiffness": YOUNG * AREA, "mass": MASS}
    out["loads"] = [share * BENDING / LENGTH**2 for share in (0.01, 0.5, 1.0, 2.0, 4.0)]
    out["tips"] = (2 * fine - coarse).tolist()
    out["period"] = 2 * fast - slow
    out["of 32 elements"] = {"tips": coarse.tolist(), "period": slow}
    out["of 64 elements"] = {"tips": fine.tolist(), "period": fast}
    json.dump(out, sys.stdout, indent=1)
    print()


main()
