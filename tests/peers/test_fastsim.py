"""Tractive energy against NREL's FASTSim 3 on certification cycles.

Both take a step's resistance at the mean of its two speeds, and the inertia's work as
the change of kinetic energy over it. FASTSim's wheels are made weightless, since ours
turn with the body's mass; its drag is worked out with the air that ``Air.get_density``
gives (1.173 kg/m³; the 1.2 that its history reports is not used there), so that is
ours too. Its g is 9.80 m/s², ours 9.80665: 0.07 % of the rolling resistance, left.
"""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
from tests.cars import truck

fastsim = pytest.importorskip("fastsim", minversion="3.1", reason="needs FASTSim 3")

G = 9.80665  # m/s²
AREA = 2.5  # m²; only its product with the drag coefficient matters
LOADS = {  # mass [kg], C_rr, C_d, frontal area [m²]
    "small": (1600.0, 0.009, 0.33, 2.51),
    "pick-up": (3152.0, 0.011, 0.30, 3.5),
}
SHIPPED = ("r1t_epa", "bmw_i3", "tesla_model_3", "twizy")  # full size, with a road load


def shipped_load(name):
    """A shipped vehicle's mass and road load; less B, which FASTSim does not have."""
    vehicle = load_vehicle(name)
    mass = vehicle.body.mass_kg.value
    figures = {
        key: figure.value
        for effect in ("road_load", "rolling_resistance", "aerodynamic_drag")
        for key, figure in vehicle.effects.get(effect, {}).items()
    }
    if "a_n" in figures:
        C_rr = figures["a_n"] / (mass * G)
        drag_area = 2 * figures["c_n_s2_per_m2"] / fastsim.Air.get_density()
    else:
        C_rr, drag_area = figures["coefficient"], figures["drag_area_m2"]
    return mass, C_rr, drag_area / AREA, AREA


def fastsim_tractive_power(cycle, mass, C_rr, C_d, area):
    """Power at FASTSim's wheels over each step of the cycle. [W]"""
    model = fastsim.Vehicle.from_resource("2022_Renault_Zoe_ZE50_R135.yaml").to_dict()
    model["mass_kilograms"] = mass
    # parts' masses would have to add up to the vehicle's; power: never short of it
    model["chassis"] |= {
        "glider_mass_kilograms": None,
        "cargo_mass_kilograms": None,
        "wheel_rr_coef": C_rr,
        "drag_coef": C_d,
        "frontal_area_square_meters": area,
        "wheel_inertia_kilogram_square_meters": 0.0,
    }
    model["pt_type"]["BEV"]["em"]["pwr_out_max_watts"] = 400e3
    trace = {
        "name": cycle.name,
        "time_seconds": cycle.time_s.tolist(),
        "speed_meters_per_second": cycle.speed_mps.tolist(),
    }
    drive = fastsim.SimDrive(
        fastsim.Vehicle.from_dict(model), fastsim.Cycle.from_dict(trace)
    )
    drive.run()
    table = drive.to_dataframe()
    history = {
        name: table[f"veh.history.{name}"].to_numpy()
        for name in (
            "pwr_tractive_watts", "speed_ach_meters_per_second", "mass_kilograms"
        )
    }  # fmt: skip
    assert np.array_equal(history["speed_ach_meters_per_second"], cycle.speed_mps)
    assert (history["mass_kilograms"][1:] == mass).all()
    return history["pwr_tractive_watts"][1:]


def our_tractive_power(cycle, mass, C_rr, C_d, area):
    """Power of an ideal drivetrain over each step of an imposed run. [W]"""
    ideal = truck(
        {
            "rolling_resistance": {"coefficient": C_rr},
            "aerodynamic_drag": {
                "drag_area_m2": C_d * area,
                "air_density_kg_per_m3": fastsim.Air.get_density(),
            },
        },
        body__mass_kg=mass,
    )
    run = simulate(ideal, cycle, imposed=True)
    assert run.ledger.get("brakes", 0.0) == 0.0
    return run.trace["battery_power_w"][1:]


def tractive_energies(name, load):
    """Positive and net tractive energy, FASTSim's and ours. [J]"""
    cycle = parse_cycle(name)
    dt = np.diff(cycle.time_s)
    powers = (
        model(cycle, *load) for model in (fastsim_tractive_power, our_tractive_power)
    )
    return [(np.sum(np.maximum(P, 0) * dt), np.sum(P * dt)) for P in powers]


@pytest.mark.parametrize("load", [*LOADS, *SHIPPED])
@pytest.mark.parametrize("name", ["udds", "hwfet", "us06", "wltc_3b"])
def test_tractive_energy_is_that_of_fastsim(name, load):
    of = LOADS[load] if load in LOADS else shipped_load(load)
    theirs, ours = tractive_energies(name, of)
    assert theirs[0] > theirs[1] > 0
    assert ours == pytest.approx(theirs, rel=0.005)
