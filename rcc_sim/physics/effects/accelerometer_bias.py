"""An accelerometer that reads something at rest."""

from rcc_sim.physics.effect import Effect, Param, Sought


def sensed(columns, time, x, y):
    """Columns of a log whose accelerometer has a bias along x and y [m/s²]."""
    bias = {"accel_x_mps2": x, "accel_y_mps2": y}
    return {name: columns[name] + b for name, b in bias.items() if name in columns}


EFFECT = Effect(
    id="accelerometer_bias",
    title="bias of the accelerometer",
    equation="accel -> accel + bias",
    params=(
        Param(
            "x_mps2",
            neutral=0.0,
            bounds=(-10.0, 10.0),
            typical=(-0.5, 0.5),
            about="forward acceleration read at rest",
            optional=True,
            sought=Sought(columns=("accel_x_mps2",)),
        ),
        Param(
            "y_mps2",
            neutral=0.0,
            bounds=(-10.0, 10.0),
            typical=(-0.5, 0.5),
            about="lateral acceleration read at rest",
            optional=True,
            sought=Sought(columns=("accel_y_mps2",)),
        ),
    ),
    channels=("accel_x_mps2", "accel_y_mps2"),
    seen_as="an acceleration at standstill on level ground",
    source="definition; the sensor, not the car: it touches the log alone",
    sensor=True,
    also=("imu bias", "accelerometer offset"),
)
