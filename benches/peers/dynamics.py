"""One step of a rope in MuJoCo 3 (a cable of as many bodies as the spline has vertices, held at as many of them as the spline has rings
to slide through: MuJoCo has no constraint that slides) and in PyElastica 1 (as many elements, held at one end: no constraint holds it
elsewhere). On the sizes of benches/dynamics.rs; processor time of one thread, median. Where a library is not installed its column
stays empty, and it says so.

    OPENBLAS_NUM_THREADS=1 python3 benches/peers/dynamics.py     # mujoco==3.17.0, pyelastica==1.0.0
"""
import json
import pathlib
import statistics
import sys
import time

import numpy as np

CASES = ((60, 14), (250, 20), (1000, 20), (10_000, 20), (100_000, 20))


def told(who, size, step, samples=7):
    """The median of `samples` times of a step, each of at least 50 ms and a step."""
    step()
    times = []
    for _ in range(samples):
        start, count = time.process_time(), 0
        while True:
            step()
            count += 1
            if time.process_time() - start > 0.05:
                break
        times.append((time.process_time() - start) / count)
    median = 1e9 * statistics.median(times)
    if len(sys.argv) > 1:
        folder = pathlib.Path(sys.argv[1], "W6 rope, a step", who, str(size), "new")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "estimates.json").write_text(json.dumps({"median": {"point_estimate": median}}))
    else:
        print(f"| {who} | {size} | {1e-3 * median:.1f} µs |", flush=True)


def mujoco_cable(n, held):
    import mujoco

    held = "".join(f'<connect body1="cB_{k}" anchor="0 0 0"/>' for k in np.linspace(3, n - 5, held).astype(int))
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <extension><plugin plugin="mujoco.elasticity.cable"/></extension>
      <option timestep="0.002" gravity="0 0 -9.81" integrator="implicitfast" jacobian="sparse"><flag contact="disable"/></option>
      <size memory="4G"/>
      <worldbody><composite prefix="c" type="cable" curve="s" count="{n + 1} 1 1" size="{0.1 * n}" initial="none">
        <plugin plugin="mujoco.elasticity.cable"><config key="twist" value="1e6"/><config key="bend" value="1e6"/></plugin>
        <joint kind="main" damping=".01"/><geom type="capsule" size=".005"/>
      </composite></worldbody>
      <equality>{held}</equality>
    </mujoco>""")
    data = mujoco.MjData(model)
    return lambda: mujoco.mj_step(model, data)


def elastica_rod(n):
    import elastica as ea

    class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
        pass

    simulator, length, young, density = Simulator(), 0.1 * n, 1e6, 1000.0
    rod = ea.CosseratRod.straight_rod(
        n, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), length, 0.005, density,
        youngs_modulus=young, shear_modulus=young / 3,
    )
    simulator.append(rod)
    simulator.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulator.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array([0, 0, -9.81]))
    simulator.finalize()
    stepper, now, step = ea.PositionVerlet(), [np.float64(0)], np.float64(0.1 * 0.1 / np.sqrt(young / density))

    def advance():
        now[0] = stepper.step(simulator, now[0], step)

    return advance


for size, held in CASES:
    try:
        # Coordinates along the chain make the mass matrix full: 7 s a step with 1000 bodies, and growing with their cube.
        if size <= 250:
            told("MuJoCo cable", size, mujoco_cable(size, held))
        elif size == 1000:
            told("MuJoCo cable", size, mujoco_cable(size, held), samples=1)
    except ImportError as missing:
        print(f"SKIPPED: {missing}", file=sys.stderr)
    try:
        told("PyElastica", size, elastica_rod(size))
    except ImportError as missing:
        print(f"SKIPPED: {missing}", file=sys.stderr)
