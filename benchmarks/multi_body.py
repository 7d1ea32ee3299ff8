"""Our single track beside CommonRoad's multi-body model, a distant relative.

    python -m benchmarks.multi_body

Vehicle 2 of commonroad-vehicle-models (a BMW 320i), 29 states: sprung and two unsprung
masses, four wheels, magic-formula tyres with camber and combined slip. Ours gets its
mass, yaw inertia, axle distances and, from its static wheel loads, its cornering
stiffness; nothing is fitted. Both steer alike, at the speed that the multi-body model
drove: 20 random gentle drives, and steady corners. What makes the difference is found
by taking parts out of theirs one after the other.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import Vehicle, build
from rcc_sim.simulate.run import simulate

G = 9.81  # m/s²; a literal in their models
DURATION = 8.0  # s
RATE = 200.0  # Hz
DRIVES = 20
ACROSS = 2.0  # m/s²; about the most lateral acceleration of a random drive
FOLLOW = 2.0  # 1/s; how their speed is held
CORNERS = ((8.0, 0.02), (15.0, 0.01), (25.0, 0.005))  # m/s, rad

CAMBER = {"p_hy1": 0.0, "p_hy3": 0.0, "p_vy1": 0.0, "p_vy3": 0.0, "p_dy3": 0.0}
COMBINED = {"r_by1": 0.0, "r_vy1": 0.0, "r_vy3": 0.0, "r_hy1": 0.0,
            "r_bx1": 0.0, "r_hx1": 0.0}  # fmt: skip
# N m/rad and N/m; theirs are some 5e3 and 1.8e5, so that body and axles now move as one
STIFF = {"K_tsf": -1e6, "K_tsr": -1e6, "K_ras": 2e7}

Signal = Callable[[Any], Any]


@dataclass(frozen=True)
class Model:
    """What of their model is changed, and what of ours.

    Parameters
    ----------
    name : str
    tyre, body : dict
        Their parameters that are replaced, of the tyre and of the rest.
    saturating : bool
        Whether our tyres saturate, with their friction.
    """

    name: str
    tyre: dict[str, float]
    body: dict[str, float]
    saturating: bool = False

    def parameters(self) -> Any:
        """Return their parameters with what is replaced."""
        from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

        p = setup_vehicle_parameters(vehicle_id=2)
        for name, value in self.tyre.items():
            setattr(p.tire, name, value)
        for name, value in self.body.items():
            setattr(p, name, value)
        return p


LOW = {"h_s": 0.354}  # m; 1 cm above the axles in place of 0.614


MODELS = (
    Model("as it is", {}, {}),
    Model("without camber thrust", CAMBER, {}),
    Model("nor combined slip", CAMBER | COMBINED, {}),
    Model("and our tyres saturating", CAMBER | COMBINED, {}, saturating=True),
    Model("nor roll against the axles", CAMBER | COMBINED, STIFF, saturating=True),
    Model("nor mass above them", CAMBER | COMBINED, STIFF | LOW, saturating=True),
)


def their_motion(p: Any, t: NDArray[np.float64], speed: Signal, steer: Signal) -> Any:
    """Return their 29 states at the times t, (29, n)."""
    from scipy.integrate import solve_ivp
    from vehiclemodels.init_mb import init_mb
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

    h = 1e-4

    def slope(signal: Signal, time: float) -> float:
        return float(signal(time + h) - signal(time - h)) / (2 * h)

    def rates(time: float, state: NDArray[np.float64]) -> Any:
        x = state.tolist()
        x[2] = float(steer(time))
        a = slope(speed, time) + FOLLOW * (float(speed(time)) - x[3])
        return vehicle_dynamics_mb(x, [slope(steer, time), a], p)

    start = init_mb([0.0, 0.0, float(steer(0.0)), float(speed(0.0)), 0.0, 0.0, 0.0], p)
    done = solve_ivp(
        rates, (t[0], t[-1]), start, "LSODA", t_eval=t, rtol=1e-6, atol=1e-8
    )
    if not done.success:
        raise RuntimeError(f"their model could not be integrated: {done.message}")
    return done.y


def axle_stiffness(p: Any) -> tuple[float, float]:
    """Return cornering stiffness of the front and the rear axle: -p_ky1 F_z. [N/rad]"""
    length = p.a + p.b
    front = G * (p.m_s * p.b / length + p.m_uf)
    rear = G * (p.m_s * p.a / length + p.m_ur)
    return -p.tire.p_ky1 * front, -p.tire.p_ky1 * rear


def our_car(p: Any, saturating: bool = False) -> Vehicle:
    """Return their vehicle as a single track."""
    front, rear = axle_stiffness(p)
    effects = {"tyre_saturation": {"friction_coefficient": float(p.tire.p_dy1)}}
    raw = {
        "vehicle": {"name": "relative"},
        "body": {
            "mass_kg": p.m,
            "yaw_inertia_kgm2": p.I_z,
            "cg_to_front_axle_m": p.a,
            "cg_to_rear_axle_m": p.b,
        },
        "tyres": {
            "radius_m": p.R_w,
            "front_cornering_stiffness_n_per_rad": front / 2,
            "rear_cornering_stiffness_n_per_rad": rear / 2,
        },
        "drivetrain": {"gear_ratio": 9.0},
        "controller": {
            "mode": "torque",
            "max_torque_nm": 1e4,
            "loop_rate_hz": 25 * RATE,
        },
        "effects": effects if saturating else {},
    }
    return build(raw, path=None)


def our_motion(
    car: Vehicle, t: NDArray[np.float64], v: NDArray[np.float64], steer: Signal
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return our yaw rate [rad/s] and lateral velocity [m/s] at the speed v."""
    from scipy.interpolate import CubicSpline

    fine = np.linspace(t[0], t[-1], 25 * (len(t) - 1) + 1)
    trace = simulate(
        car, Cycle("given", t, v), steer=(fine, steer(fine)), output_rate=RATE
    ).trace
    psi = trace["yaw_rad"]
    # lateral velocity is no column: the path's velocity along the body's y
    dx, dy = (CubicSpline(t, trace[c])(t, 1) for c in ("x_m", "y_m"))
    return trace["yaw_rate_radps"], dy * np.cos(psi) - dx * np.sin(psi)


def random_drive(seed: int, length: float) -> tuple[Signal, Signal]:
    """Return speed [m/s] and steering angle [rad] over time, both smooth and gentle."""
    draw = np.random.default_rng(seed)
    v_0 = draw.uniform(8.0, 25.0)
    swing, slow = draw.uniform(0.0, 1.0), 2 * np.pi * draw.uniform(0.05, 0.15)
    omega = 2 * np.pi * draw.uniform(0.1, 1.0, 3)
    phase = draw.uniform(0.0, 2 * np.pi, 3)
    share = draw.uniform(0.2, 1.0, 3)
    share *= ACROSS * length / v_0**2 / share.sum()

    def speed(t: Any) -> Any:
        return v_0 + swing * np.sin(slow * np.asarray(t))

    def steer(t: Any) -> Any:
        time = np.asarray(t)
        start = np.tanh(time) ** 2  # from straight ahead
        waves = zip(share, omega, phase, strict=True)
        return start * sum(a * np.sin(w * time + q) for a, w, q in waves)

    return speed, steer


def apart(model: Model, seed: int) -> tuple[float, float, float]:
    """Return how far yaw rate and lateral velocity lie apart, RMS.

    The first two over their size [1], then the latter as it is. [m/s]
    """
    p = model.parameters()
    t = np.linspace(0.0, DURATION, round(DURATION * RATE) + 1)
    speed, steer = random_drive(seed, p.a + p.b)
    theirs = their_motion(p, t, speed, steer)
    r, v_y = our_motion(our_car(p, model.saturating), t, theirs[3], steer)
    return (
        rms(r - theirs[5]) / rms(theirs[5]),
        rms(v_y - theirs[10]) / rms(theirs[10]),
        rms(v_y - theirs[10]),
    )


def steady_yaw_rates(model: Model, v: float, delta: float) -> tuple[float, float]:
    """Return their yaw rate once a corner is steady, and the single track's. [rad/s]

    The latter in closed form: v δ / (l + K v²), K = m (l_R C_R - l_F C_F) / (l C_F C_R)
    with the axles' stiffnesses, at the speed that they came to.
    """
    p = model.parameters()
    t = np.linspace(0.0, DURATION, 81)
    theirs = their_motion(
        p,
        t,
        lambda x: v + 0 * np.asarray(x),
        lambda x: 0.5 * delta * (1 + np.tanh(4 * (np.asarray(x) - 1.5))),
    )
    front, rear = axle_stiffness(p)
    length = p.a + p.b
    K = p.m * (p.b * rear - p.a * front) / (length * front * rear)
    speed = float(theirs[3][-1])
    return float(theirs[5][-1]), speed * delta / (length + K * speed**2)


def rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def main() -> None:
    """Print both tables."""
    if importlib.util.find_spec("vehiclemodels") is None:
        print("multi-body: left out, commonroad-vehicle-models is not installed")
        return
    print(f"{DRIVES} random drives, difference, RMS: mean and worst; its lateral")
    print(
        "velocity passes through zero near 18 m/s, where a small one is a large share"
    )
    print(f"{'their multi-body model':28s}  yaw rate, %   lateral velocity, % and mm/s")
    for model in MODELS:
        found = np.array([apart(model, seed) for seed in range(DRIVES)])
        mean, worst = found.mean(axis=0), found.max(axis=0)
        print(
            f"{model.name:28s} {100 * mean[0]:5.2f} {100 * worst[0]:6.2f}"
            f"   {100 * mean[1]:7.2f} {100 * worst[1]:6.2f}"
            f"    {1e3 * mean[2]:6.2f} {1e3 * worst[2]:6.2f}"
        )
    print("steady corners: their yaw rate over the single track's, less one, %")
    heads = "".join(f"{v:6.0f} m/s" for v, _ in CORNERS)
    print(f"{'':28s}{heads}")
    for model in MODELS[:3]:
        ratios = [np.divide(*steady_yaw_rates(model, *corner)) for corner in CORNERS]
        print(f"{model.name:28s}" + "".join(f"{100 * (x - 1):+10.2f}" for x in ratios))


if __name__ == "__main__":
    main()
