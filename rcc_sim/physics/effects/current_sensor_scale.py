"""A battery current that is read too high or too low."""

from rcc_sim.physics.effect import Effect, Param


def sensed(columns, time, scale):
    """Columns of a log whose battery current reads `scale` times the true one."""
    seen = ("battery_current_a", "battery_power_w")
    return {name: columns[name] * scale for name in seen if name in columns}


EFFECT = Effect(
    id="current_sensor_scale",
    title="scale of the current sensor",
    equation="battery_current_a -> scale battery_current_a",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.2, 5.0),
            typical=(0.9, 1.1),
            about="current read over the true one",
        ),
    ),
    channels=("battery_current_a", "battery_power_w"),
    seen_as="battery power off by a factor at every speed, both ways",
    source="definition; the sensor, not the car: it touches the log alone",
    sensor=True,
    also=("shunt",),
)
