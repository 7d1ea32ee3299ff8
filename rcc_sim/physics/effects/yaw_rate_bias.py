"""A gyroscope that turns at rest."""

from rcc_sim.physics.effect import Effect, Param


def sensed(columns, time, bias):
    """Columns of a log whose gyroscope has a bias [rad/s]."""
    name = "yaw_rate_radps"
    return {name: columns[name] + bias} if name in columns else {}


EFFECT = Effect(
    id="yaw_rate_bias",
    title="bias of the gyroscope",
    equation="yaw_rate_radps -> yaw_rate_radps + bias",
    params=(
        Param(
            "bias_radps",
            neutral=0.0,
            bounds=(-1.0, 1.0),
            typical=(-0.02, 0.02),
            about="yaw rate read at rest",
        ),
    ),
    channels=("yaw_rate_radps",),
    seen_as="a yaw rate at standstill, and the same on top of every other",
    source="definition; the sensor, not the car: it touches the log alone",
    sensor=True,
    also=("gyro bias", "gyro offset", "imu bias"),
)
