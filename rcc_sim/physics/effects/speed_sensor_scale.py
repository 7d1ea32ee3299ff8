"""A motor speed that is read too high or too low."""

from rcc_sim.physics.effect import Effect, Param


def sensed(columns, time, scale):
    """Columns of a log whose motor speed reads `scale` times the true one."""
    seen = ("speed_mps", "motor_speed_radps")
    return {name: columns[name] * scale for name in seen if name in columns}


EFFECT = Effect(
    id="speed_sensor_scale",
    title="scale of the speed sensor",
    equation="speed_mps -> scale speed_mps",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.2, 5.0),
            typical=(0.9, 1.1),
            about="speed read over the true one",
        ),
    ),
    channels=("speed_mps",),
    seen_as="speed that disagrees with pose and acceleration by a factor",
    source="definition; the sensor, not the car: it touches the log alone",
    sensor=True,
    shows_in=("turning",),
    also=("speedometer",),
)
