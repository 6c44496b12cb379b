"""What a sensor makes of a quantity."""

from math import exp

import numpy as np

from tcp_muscle_ros.muscle.sensors import BLOCK, Noise, Sensor


def test_an_ideal_sensor_shows_the_quantity_to_the_last_bit():
    assert Sensor().ideal
    assert [Sensor().read(value, 0.01, 1.7) for value in (0.1, -3.3e-5)] == [0.1, -3.3e-5]


def test_a_lag_answers_a_step_with_its_exponential_whatever_the_rate():
    for dt in (0.5, 0.01):
        sensor = Sensor(lag=2.0)
        sensor.read(0.0, dt, 0.0)
        shown = [sensor.read(1.0, dt, 0.0) for _ in range(round(4.0 / dt))]
        assert abs(shown[-1] - (1.0 - exp(-2.0))) < 1e-12
        sensor.reset()
        assert sensor.read(5.0, dt, 0.0) == 5.0


def test_noise_then_steps():
    sensor = Sensor(noise=0.5, quantum=0.2)
    assert sensor.read(1.0, 0.01, 0.3) == 6 * 0.2  # 1.15, and the nearest step
    assert not sensor.ideal


def test_the_draws_go_on_over_blocks_and_depend_on_the_seed_alone():
    rows = [Noise(5, 4).row() for _ in range(2)]
    assert rows[0] == rows[1]
    noise = Noise(5, 4)
    drawn = np.array([noise.row() for _ in range(3 * BLOCK)])
    assert np.array_equal(drawn, np.random.default_rng(5).standard_normal((3 * BLOCK, 4)))
