"""The numbers in docs/hardware.md, on which somebody heats a real muscle, are the model's."""

from pathlib import Path

import pytest

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters, critical_current, steady_current, steady_temperature

PAGE = (Path(__file__).resolve().parents[1] / 'docs' / 'hardware.md').read_text(encoding='utf-8')
# A document breaks its lines where it likes.
TEXT = ' '.join(PAGE.split())
ROOM = 23.0 + ZERO_CELSIUS
SIXTY_GRAMS = 0.060 * 9.80665


@pytest.fixture
def paper():
    return Parameters.named('karami_tadesse_2017')


def held(parameters, drive, kind, seconds):
    """The muscle under 60 g in a room of 23 degC after a constant drive."""
    muscle = Muscle(parameters, load=SIXTY_GRAMS, ambient=ROOM)
    for _ in range(round(seconds / 0.1)):
        reading = muscle.step(0.1, drive, kind)
    return reading


def shown(reading):
    temperature = reading.temperature - ZERO_CELSIUS
    return f'{temperature:.0f} °C, {reading.resistance:.1f} Ω, {1e3 * reading.displacement:.0f} mm'


def test_limits(paper):
    assert f'| thermal runaway | {critical_current(paper):.3f} A |' in TEXT
    assert f'| settles at 120 °C | {steady_current(paper, 120.0 + ZERO_CELSIUS, ROOM):.2f} A |' in TEXT
    tested = held(paper, 0.27, 'current', 600.0)
    settled = steady_temperature(paper, 0.27, ROOM) - ZERO_CELSIUS
    assert f'about {settled:.0f} °C once settled, {tested.voltage:.1f} V, {tested.power:.1f} W' in TEXT


def test_a_supply_of_5_volts_is_a_limit(paper):
    reading = held(paper, 5.0, 'voltage', 600.0)
    assert 'voltage limit to 5 V' in TEXT
    assert f'cannot pass {reading.temperature - ZERO_CELSIUS:.0f} °C in still air' in TEXT
    assert reading.in_domain


def test_first_steps(paper):
    first = held(paper, 0.02, 'current', 600.0)
    warmed, moved = first.temperature - ROOM, 1e3 * first.displacement
    assert f'warms by {warmed:.1f} K and moves by {moved:.1f} mm. `resistance` shows {first.resistance:.0f} Ω' in TEXT

    second = held(paper, 0.10, 'current', 60.0)
    assert f'about {shown(second)} under 60 g' in TEXT
    third = held(paper, 0.15, 'current', 60.0)
    assert f'About {shown(third)}' in TEXT


def test_resistance_rises(paper):
    hot = paper['R0'] * (1.0 + paper['a_R'] * (80.0 - 23.0))
    assert f'R rises by {100.0 * (hot / paper["R0"] - 1.0):.0f} % on the way to 80 °C' in TEXT
