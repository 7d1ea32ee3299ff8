"""A distant relative: CommonRoad's multi-body model beside the single track.

What parts them is camber thrust, combined slip and the roll of the sprung mass; with
these out of their model it should come to the single track, and does.
"""

import numpy as np
import pytest

from benchmarks import multi_body

pytest.importorskip("vehiclemodels", reason="needs commonroad-vehicle-models")

AS_IT_IS, NO_CAMBER, NO_COMBINED, *_, NO_ROLL = multi_body.MODELS
SEEDS = range(5)


@pytest.mark.parametrize(
    ("model", "bound"), [(AS_IT_IS, 0.06), (NO_CAMBER, 0.002), (NO_COMBINED, 0.001)]
)
@pytest.mark.parametrize(("speed", "steer"), multi_body.CORNERS)
def test_a_steady_corner_has_the_single_tracks_yaw_rate(model, bound, speed, steer):
    theirs, single_track = multi_body.steady_yaw_rates(model, speed, steer)
    assert single_track > 0
    assert theirs == pytest.approx(single_track, rel=bound)


@pytest.mark.thorough
def test_the_less_camber_and_roll_they_have_the_nearer_they_come():
    mean = [
        np.mean([multi_body.apart(model, seed) for seed in SEEDS], axis=0)
        for model in (AS_IT_IS, NO_CAMBER, NO_ROLL)
    ]
    yaw_rate, _, lateral_velocity = np.transpose(mean)
    assert (np.diff(yaw_rate) < 0).all()
    assert (np.diff(lateral_velocity) < 0).all()
    assert yaw_rate[0] < 0.10
    assert yaw_rate[2] < 0.015
