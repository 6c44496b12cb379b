"""The resolved model written a second time, from docs/paper.md and not from the package, for the tests to compare with.

Plain Python, degC as in the paper, and an adaptive integrator in place of the exact step.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.80665
CURRENTS = (0.18, 0.21, 0.24, 0.27)
LOADS = tuple(grams * 1e-3 * GRAVITY for grams in (30, 60, 100))


@dataclass(frozen=True)
class Sample:
    """Set A, written out. Temperatures in degC."""

    R0: float = 14.0
    a_R: float = 0.003
    C: float = 0.17
    hA: float = 0.01933
    T0: float = 23.0
    k0: float = 23.0
    H0: float = 0.150
    B: float = 0.25 / 0.15

    def heating(self, kind, drive, celsius):
        """W."""
        ohm = self.R0 * (1 + self.a_R * (celsius - self.T0))
        return {'current': drive**2 * ohm, 'power': drive, 'voltage': drive**2 / ohm}[kind]

    def heat_up(self, kind, drive, celsius, ambient, seconds):
        """Temperature (degC), heat put in and heat lost (J) after a constant drive, by DOP853 at rtol 1e-12."""

        def rate(_, y):
            heating, loss = self.heating(kind, drive, y[0]), self.hA * (y[0] - ambient)
            return (heating - loss) / self.C, heating, loss

        done = solve_ivp(rate, (0.0, seconds), (celsius, 0.0, 0.0), method='DOP853', rtol=1e-12, atol=1e-12)
        assert done.success
        return done.y[:, -1]

    def stiffness(self, celsius):
        """N/m; the modulus is held outside 0 to 120 degC."""

        def megapascal(t):
            return 536.0 - 0.4655 * t**1.381

        return self.k0 * megapascal(np.clip(celsius, 0.0, 120.0)) / megapascal(self.T0)

    def thermal(self, celsius):
        """The length (m) that heating adds; negative above T0."""
        return self.B * (4.20e-4 - 3.50e-6 * (celsius + 273.15)) * (celsius - self.T0)

    def length(self, celsius, force):
        """Length (m) under a tension (N)."""
        return self.H0 + self.thermal(celsius) + force / self.stiffness(celsius)

    def force(self, celsius, distance, compliance=0.0):
        """Tension (N) between two points this far apart (m), with a spring of this compliance (m/N) in between."""
        stretch = distance - self.H0 - self.thermal(celsius)
        return np.maximum(0.0, stretch / (1.0 / self.stiffness(celsius) + compliance))


SET_A = Sample()
SET_B = replace(SET_A, hA=0.015, C=0.272)
AS_PRINTED = replace(SET_A, hA=0.15)
