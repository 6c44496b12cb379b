"""A joint's two currents: the law of ``antagonist`` and a tracking controller for each of its muscles, in one."""

from dataclasses import dataclass

from tcp_muscle_ros.control.antagonist import FREE, Antagonist, Hold, Side
from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.tracking import TrackingController


@dataclass(frozen=True)
class Measured:
    """What is measured of a joint at one instant; pairs: agonist, antagonist."""

    angle: float  # rad
    tensions: tuple[float, float]  # N
    temperatures: tuple[float, float]  # K
    currents: tuple[float, float]  # A, flowing from now until the command takes effect
    ambients: tuple[float, float]  # K


class JointController:
    """Angle and co-contraction or stiffness in, the currents (A) of both muscles out, once a period.

    Args:
        agonist: turns the joint towards positive angles.
        antagonist: turns it back.
        radius: m, of the pulley.
        period: s.
        filter_time: s, with which the torque is followed that the tensions show.
    """

    def __init__(self, agonist: Side, antagonist: Side, radius: float, period: float, filter_time: float = 0.3) -> None:
        sides = agonist, antagonist
        self.law = Antagonist(agonist, antagonist, radius, period, filter_time)
        self._arms = radius, -radius
        self._inverses = [Inverse(side.model, side.mounted_load) for side in sides]
        self._trackers = [
            TrackingController(
                side.model,
                period,
                side.current_limit,
                side.mounted_load,
                side.model['T0'],
                temperature_limit=side.temperature_limit,
            )
            for side in sides
        ]

    def update(
        self,
        setpoint: float,
        cocontraction: float,
        measured: Measured,
        *,
        stiffness: float | None = None,
        hold: Hold = FREE,
    ) -> tuple[float, ...]:
        """One period; arguments as in ``Antagonist.update``. Returns both currents, A, for the next period."""
        wanted = self.law.update(
            setpoint,
            cocontraction,
            measured.angle,
            measured.tensions,
            measured.ambients,
            stiffness=stiffness,
            hold=hold,
        )
        return tuple(
            tracker.update(
                inverse.displacement(target, tension),
                displacement=arm * measured.angle,
                load=tension,
                ambient=ambient,
                temperature=temperature,
                applied_current=current,
            ).current
            for tracker, inverse, target, arm, tension, ambient, temperature, current in zip(
                self._trackers,
                self._inverses,
                wanted,
                self._arms,
                measured.tensions,
                measured.ambients,
                measured.temperatures,
                measured.currents,
                strict=True,
            )
        )
