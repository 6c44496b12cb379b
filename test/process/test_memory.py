"""Memory that is free again goes back to the system."""

from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.process.memory import give_back

STATM = Path('/proc/self/statm')
PIECE, COUNT, KEPT_EVERY = 64_000, 3000, 50  # bytes: below what glibc would map by itself


def resident():
    """MB that this process holds."""
    return int(STATM.read_text().split()[1]) * 4096 / 1e6


@pytest.mark.skipif(not STATM.exists(), reason='tells by /proc what a process holds')
def test_what_is_free_between_pieces_in_use_is_returned():
    pieces = [np.ones(PIECE, np.uint8) for _ in range(COUNT)]
    kept = pieces[::KEPT_EVERY]
    del pieces
    before = resident()
    give_back()
    assert before - resident() > 0.8 * PIECE * COUNT / 1e6 * (1 - 1 / KEPT_EVERY)
    assert all(piece[0] == 1 for piece in kept)
