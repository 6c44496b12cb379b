"""The muscle with nothing concealed: physics.md 1.3, drawn around the nominal numbers, as the tables of a Plant."""

from dataclasses import dataclass

import numpy as np

from proof.truth.plant import D_GRID, F_GRID, GRAVITY, H_GRID, KELVIN, T_GRID, Array, Plant

MODULUS_ZERO = 536.0  # MPa


@dataclass(frozen=True)
class Body:
    """The base parameters (set A by default): degC, otherwise SI."""

    R0: float = 14.0
    a_R: float = 0.003
    C: float = 0.17
    hA: float = 0.01933
    k0: float = 23.0
    H0: float = 0.150
    B: float = 0.5**2 / 0.150  # m, stroke gain
    c1: float = -3.50e-6
    c2: float = 4.20e-4
    T0: float = 23.0

    def steady_current(self, T: float, ambient: float) -> float:
        """The constant current that ends at T, A."""
        return float(np.sqrt(self.hA * (T - ambient) / (self.R0 * (1.0 + self.a_R * (T - self.T0)))))

    def steady_resistance(self, T: float) -> float:
        """ohm at T degC."""
        return self.R0 * (1.0 + self.a_R * (T - self.T0))


def draw_body(rng: np.random.Generator, spread: float = 1.0) -> Body:
    """A muscle as another lab would wind it: every base parameter moved off its nominal value."""
    nominal = Body()

    def moved(value: float, share: float) -> float:
        return float(value * np.exp(spread * share * np.clip(rng.standard_normal(), -2.0, 2.0)))

    H0 = moved(nominal.H0, 0.03)
    return Body(
        R0=moved(nominal.R0, 0.06),
        a_R=moved(nominal.a_R, 0.08),
        C=moved(nominal.C, 0.12),
        hA=moved(nominal.hA, 0.12),
        k0=moved(nominal.k0, 0.08),
        H0=H0,
        # Published strokes lie below what eq. 26 gives, so the gain is drawn from 0.55 to 1.05 of it.
        B=nominal.B * float(rng.uniform(0.55, 1.05)) ** spread,
        c1=nominal.c1,
        c2=nominal.c2,
    )


def modulus_ratio(T: Array, T0: float = 23.0) -> Array:
    """E(T)/E(T0) of eq. 27, T in degC, kept above zero beyond its domain."""
    warm = np.maximum(T, 0.0)
    return np.maximum(MODULUS_ZERO - 0.4655 * warm**1.381, 20.0) / (MODULUS_ZERO - 0.4655 * T0**1.381)


def free_change(body: Body, T: Array) -> Array:
    """Thermal change of length, m (negative when shorter): eq. 26 in kelvin, read as a secant."""
    return body.B * (body.c1 * (T + KELVIN) + body.c2) * (T - body.T0)


def plain(body: Body) -> Plant:
    """The Plant of a muscle of which the resolved model is all there is."""
    return Plant(
        R0=body.R0,
        C=body.C,
        hA=body.hA,
        k0=body.k0,
        H0=body.H0,
        T0=body.T0,
        rho=1.0 + body.a_R * (T_GRID - body.T0),
        loss=np.ones_like(T_GRID),
        capacity=np.ones_like(T_GRID),
        free=free_change(body, T_GRID),
        soft=modulus_ratio(T_GRID, body.T0),
        shift=np.ones_like(T_GRID),
        loop_centre=np.zeros_like(T_GRID),
        piezo=np.ones_like(H_GRID),
        area=np.ones_like(H_GRID),
        stop=np.zeros_like(H_GRID),
        spring=D_GRID.copy(),
        gain=np.ones_like(F_GRID),
        shell_share=np.ones(1),
        shell_link=np.zeros(0),
        shell_pull=np.ones(1),
    )


def weight(grams: float) -> float:
    """N."""
    return grams * 1e-3 * GRAVITY
