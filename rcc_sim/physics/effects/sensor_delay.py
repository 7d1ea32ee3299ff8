"""Sensors whose readings arrive late."""

from math import inf

from rcc_sim.jit import compiled, compiler_is_loaded, jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.physics.tables import seek

SAMPLED = ("speed_mps", "motor_speed_radps", "yaw_rate_radps")
"""Columns that are samples at a row's time; the others are means since the row before.
"""

CHANNELS = (
    ("speed_mps", "motor_speed_radps"),
    ("yaw_rate_radps",),
    ("accel_x_mps2", "accel_y_mps2"),
    (
        *("motor_current_a", "current_d_a", "current_q_a", "motor_torque_nm"),
        *("voltage_d_v", "voltage_q_v"),
    ),
    ("battery_voltage_v", "battery_current_a", "battery_power_w"),
)
"""Columns that each sensor gives, in the order of the parameters after the first."""

FEW_ROWS = 5000
"""Rows up to which a reading is delayed before a compiler would be loaded."""


def sensed(columns, time, delay, *more):
    """Columns of a log whose sensors are late by delay + more [s], sensor by sensor."""
    return {
        name: late(columns[name], time, delay + extra, name in SAMPLED)
        for names, extra in zip(CHANNELS, more, strict=True)
        for name in names
        if name in columns and delay + extra != 0.0 and len(time) > 1
    }


def behind_speed(delay, speed, *more):
    """Delays of the sensors in a drive that its own speed drives.

    Its clock is the speed's: what is as late as the speed is not late at all.
    """
    return (-speed, speed, *more)


def late(values, time, delay, sampled):
    """Readings of `delay` [s] ago, or of as much ahead where it is negative.

    Before the start the first value holds, beyond the end the last. Samples are
    interpolated, within the range that they have. Means are those of the interval that
    came `delay` earlier, from their running integral, so that no energy is lost between
    rows. Either is a cubic spline: straight lines would make half a row's delay a mean
    of two rows, and a fit would find a delay wherever smoother readings please it.
    """
    import numpy as np

    past = time - delay
    inside = np.clip(past, time[0], time[-1])
    if sampled:
        return np.clip(spline(inside, time, values), values.min(), values.max())
    steps = np.diff(time)
    total = np.concatenate([[0.0], np.cumsum(values[1:] * steps)])
    beyond = np.minimum(past - time[0], 0.0) * values[1]
    beyond += np.maximum(past - time[-1], 0.0) * values[-1]
    within = spline(inside, time, total)
    return np.concatenate([values[:1], np.diff(within + beyond) / steps])


def spline(at, time, values):
    """Cubic spline through rows, its end slopes those of its last secants.

    scipy's ``CubicSpline``: its module takes a third of a second to load, and every
    diagnosis of a car would wait for it.
    """
    import numpy as np

    slope, out = np.empty(len(time)), np.empty(len(at))
    slope[0] = (values[1] - values[0]) / (time[1] - time[0])
    slope[-1] = (values[-1] - values[-2]) / (time[-1] - time[-2])
    fast = compiler_is_loaded() or len(time) > FEW_ROWS
    bend, walk = (compiled(f) if fast else f for f in (slopes_of, along))
    bend(time, values, slope, np.zeros(len(time)))
    walk(at, time, values, slope, out)
    return out


@jit
def slopes_of(time, values, slope, left):
    """Write the slopes at which the spline bends evenly, those at its ends being given.

    A step h before and H after a row, with secants d and D: H s_- + 2 (h + H) s + h s_+
    = 3 (H d + h D), solved by elimination; ``left`` is room for as many numbers.
    """
    n = len(time)
    for i in range(1, n - 1):
        h, H = time[i] - time[i - 1], time[i + 1] - time[i]
        d, D = (values[i] - values[i - 1]) / h, (values[i + 1] - values[i]) / H
        pivot = 2.0 * (h + H) - H * left[i - 1]
        left[i] = h / pivot
        slope[i] = (3.0 * (H * d + h * D) - H * slope[i - 1]) / pivot
    for i in range(n - 2, 0, -1):
        slope[i] -= left[i] * slope[i + 1]


@jit
def along(at, time, values, slope, out):
    """Write the spline at some places that do not fall, within the rows."""
    k = 0
    for i in range(len(at)):
        k = seek(at[i], time, k)
        h = time[k + 1] - time[k]
        secant = (values[k + 1] - values[k]) / h
        u, a, b = (at[i] - time[k]) / h, slope[k], slope[k + 1]
        bend = 3.0 * secant - 2.0 * a - b + u * (a + b - 2.0 * secant)
        out[i] = values[k] + h * u * (a + u * bend)


def _rows(tried, *, of="row", columns=(), opposes=(), shows_in=()):
    return Sought(
        tried=tried,
        limits=(1.0, inf),
        of=of,
        longest=0.5,
        acts="rows",
        columns=columns,
        opposes=opposes,
        shows_in=shows_in,
    )


def _more(name, what, *columns, of="row", opposes=(), shows_in=(), least=0.0):
    return Param(
        name,
        neutral=0.0,
        bounds=(least, 2.0),
        typical=(0.005, 0.2),
        about=f"more delay of {what}, on top of delay_s",
        optional=True,
        sought=_rows(
            (1.0, 2.0, 5.0, 10.0),
            of=of,
            columns=columns,
            opposes=opposes,
            shows_in=shows_in,
        ),
    )


EFFECT = Effect(
    id="sensor_delay",
    title="delay of the sensors",
    equation="reading(t) = true(t - delay)",
    params=(
        Param(
            "delay_s",
            neutral=0.0,
            bounds=(0.0, 2.0),
            typical=(0.005, 0.2),
            about="delay of every sensor",
            optional=True,
            sought=_rows(
                (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 11.0, 15.0),
                shows_in=("commanded",),
            ),
        ),
        _more(
            "speed_delay_s",
            "the speed (motor and vehicle)",
            *("motor_current_a", "motor_torque_nm"),
            *("battery_current_a", "battery_power_w"),
            of="speed",
            opposes=("motor_current_delay_s", "battery_delay_s"),
        ),
        _more("yaw_rate_delay_s", "the yaw rate", "yaw_rate_radps"),
        _more("accel_delay_s", "the accelerations", "accel_y_mps2"),
        _more(
            "motor_current_delay_s",
            "motor current, torque and voltages",
            *("motor_current_a", "motor_torque_nm"),
            shows_in=("commanded",),
        ),
        _more(
            "battery_delay_s",
            "battery voltage, current and power; less than 0 where they were asked "
            "after the speed",
            "battery_current_a",
            "battery_power_w",
            least=-2.0,
        ),
    ),
    channels=("speed_mps", "yaw_rate_radps", "motor_current_a", "battery_power_w"),
    seen_as="a channel that shows the same shape as simulated, later",
    source="definition; the sensor, not the car: it touches the log alone",
    sensor=True,
    also=("sensor latency", "time offset"),
)
