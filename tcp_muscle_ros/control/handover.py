"""A controller that takes another model of the muscle while it works, without a step in the current.

The new model's controller runs beside the one in charge, on the same measurements, and takes over within ``FADE`` s.
The controller of the muscle's own parameters never stops: the hotter temperature of all counts, and so does the lowest
current that keeps one of them below the temperature limit. So another model never loosens a limit.
"""

from dataclasses import replace
from typing import Any

from tcp_muscle_ros.control.tracking import Command, TrackingController

FADE = 3.0  # s: several times what an observer needs to find the muscle


class Handover:
    """``own`` is the controller of the muscle as its parameters describe it, ``period`` s from update to update."""

    def __init__(self, own: TrackingController, period: float) -> None:
        self._own = self._active = own
        self._leaving: TrackingController | None = None
        self._next: TrackingController | None = None
        self._share = 1.0  # of the current that is the active controller's
        self._growth = period / FADE

    def begin(self, controller: TrackingController) -> None:
        """Start with another model in charge: nothing has flowed yet."""
        self._active = controller

    def adopt(self, controller: TrackingController | None) -> None:
        """From now on another model's controller takes over; None: the own one again. Where one takes over already,
        that is finished first."""
        self._next = controller or self._own
        if self._leaving is None:
            self._pass_on()

    def _pass_on(self) -> None:
        if self._next is not None and self._next is not self._active:
            self._leaving, self._active, self._share = self._active, self._next, 0.0
            self._active.take_over(self._leaving)
        self._next = None

    def reset(self) -> None:
        """Forget what the feedback has taught all of them."""
        for one in self._all():
            one.reset()

    def carry(self, fibre: float) -> None:
        """Begin at least so warm (K), as ``TrackingController.carry``."""
        for one in self._all():
            one.carry(fibre)

    def _all(self) -> list[TrackingController]:
        return list(dict.fromkeys(one for one in (self._own, self._active, self._leaving) if one is not None))

    def update(self, setpoint: float, **measured: Any) -> Command:
        """One period, as ``TrackingController.update``; what is expected and shaped is the active controller's."""
        commands = {one: one.update(setpoint, **measured) for one in self._all()}
        found = commands[self._active]
        current = found.current
        if self._leaving is not None:
            current = self._share * current + (1.0 - self._share) * commands[self._leaving].current
            self._share = min(self._share + self._growth, 1.0)
            if self._share >= 1.0:
                self._leaving = None
                self._pass_on()
        highest = min(one.highest_current for one in commands.values())
        hottest = max(one.predicted_temperature for one in commands.values())
        return replace(found, current=min(current, highest), highest_current=highest, predicted_temperature=hottest)
