"""Diagnose: calibrate, is the misfit real, where, which physics, how sure, what else, what next, and the better muscle.

The steps are those of docs/diagnosis.md; each is a module of this room, this one only calls them in order.
"""

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.conclusions import calibrated_values, conclude, summaries, weighed
from tcp_muscle_ros.diagnosis.answer.doubtful import named_only_if_explained, named_only_if_likely
from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, NotTestable
from tcp_muscle_ros.diagnosis.answer.handed_on import stated_rig
from tcp_muscle_ros.diagnosis.answer.repeating import beyond_what_differs, left_unexplained, run_to_run
from tcp_muscle_ros.diagnosis.fitting import switching
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.room import as_well_as_read, wandered
from tcp_muscle_ros.diagnosis.fitting.run_to_run import allowing, differing, repeating
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.noise.repeatability import Repeatability
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.search.bending import with_bent_form
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.diagnosis.search.second_start import select_twice
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.diagnosis.search.weathered import with_weather
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.settings.rig import Rig, beside, on_rig

_LEAST_SAMPLES = 30
_FAR = 4.0  # times its usual size, between its coldest and its warmest: no room goes farther by itself
_MOVES, _PLAINLY = 12.0, 100.0  # times the noise: a channel that moves; one that moves whatever a fit makes of it


class Interrupted(Exception):
    """Ctrl-C: ``partial`` is what was known by then."""

    def __init__(self, partial: Diagnosis) -> None:
        super().__init__('interrupted')
        self.partial = partial


def diagnose(
    experiments: Sequence[Experiment],
    nominal: Parameters,
    *,
    separate: Sequence[str] = (),
    rig: Rig | None = None,
    progress: Callable[[], None] | None = None,
) -> Diagnosis:
    """Diagnose recordings of one muscle against a nominal muscle.

    Args:
        experiments: prepared recordings.
        nominal: the muscle as the user believes it to be.
        separate: parameters that each recording has for itself (such as ``B`` where every run is another specimen).
        rig: the rig that they were recorded on: what its instruments do is taken as known, and the next experiment is
            one that it can do.
        progress: called now and then.

    Raises:
        Interrupted: on Ctrl-C, with what is known.
    """
    work = _Work(tuple(experiments), on_rig(nominal, rig), progress, tuple(separate), rig)
    try:
        return work.done()
    except KeyboardInterrupt:
        raise Interrupted(work.partial()) from None


class _Work:
    """The diagnosis while it is being made, so that an interruption keeps what is there."""

    def __init__(
        self,
        experiments: tuple[Experiment, ...],
        nominal: Parameters,
        progress: Callable[[], None] | None,
        separate: tuple[str, ...],
        rig: Rig | None = None,
    ) -> None:
        self.model = experiments[0].model
        self.experiments, self.nominal, self.progress, self.separate = experiments, nominal, progress, separate
        self.rig = rig
        self.latents: tuple[Latent, ...] = ()  # what the calibration begins from: when the drive of each switched
        self.wandering = False  # whether rooms that nobody read are expected to go their own ways
        self.calibration: Calibration | None = None
        self.selection: Selection | None = None
        self.seconds: dict[str, float] = {}

    def done(self) -> Diagnosis:
        why = insufficient(self.experiments)
        if why:
            return self._without_result('insufficient_data', why)
        start = time.monotonic()
        self.calibration = self._calibrated()
        self._switched(self.calibration.fit)
        self.seconds['calibrate'] = time.monotonic() - start
        fixed = any(e.fixed for e in (*self.calibration.estimates, *self.calibration.combinations))
        why = 'the recordings fix none of the parameters'
        if not fixed and not moving(self.experiments, _PLAINLY):
            return self._without_result('insufficient_data', why)
        start = time.monotonic()
        # What the muscle's own numbers may follow has no name; how runs repeat and where they differ can be said.
        untried = skipped(self.experiments) if fixed else dict.fromkeys(self.model.listed, why)
        if self.rig:
            untried |= dict.fromkeys(self.rig.effects & set(self.model.listed), 'known by --rig')
        testable = [e for e in self.model.listed if e not in untried]
        self.selection = self._selected(self.calibration, testable)
        if self._switched(self.selection.final):  # beside effects that hid it
            self.selection = self._selected(self.calibration, testable)
        if self._may_wander(self.selection):
            self.selection = self._where_rooms_wander(self.selection, testable)
        repeated = repeating(self.selection.final)
        apart = differing(self.selection.final, repeated)
        if any(c.definition.circumstance for c in self.selection.chosen):
            repeated, apart = {}, []  # it says itself why runs of one protocol differ
        if apart:
            self.selection = self._beside_what_differs({name: repeated[name] for name in apart}, testable)
        self.seconds['select'] = time.monotonic() - start
        runs = run_to_run(self.selection, self.nominal, repeated, apart)
        self.selection = named_only_if_likely(self.selection, lambda selection: weighed(selection, runs))
        if left_unexplained(self.selection, runs) is not None:
            self.selection = named_only_if_explained(self.selection)
        self.selection = with_bent_form(self.selection, self.progress)
        return conclude(self.selection, self.nominal, untried, self.seconds, runs, self.rig)

    def _calibrated(self) -> Calibration:
        return calibrate(
            self.experiments, self.nominal, latents=self.latents, separate=self.separate, progress=self.progress
        )

    def _selected(
        self, calibration: Calibration, testable: Sequence[str], repeated: Mapping[str, Repeatability] | None = None
    ) -> Selection:
        bare = as_well_as_read(in_turn(calibration.fit), self.wandering)
        found = select_twice(allowing(bare, repeated) if repeated else bare, testable, self.progress)
        if not testable:
            return found
        return with_weather(with_free_law(found, self.progress), testable, self.progress)

    def _beside_what_differs(self, repeated: Mapping[str, Repeatability], testable: Sequence[str]) -> Selection:
        """Select once more, each recording with what runs of one protocol do not share for itself: its gain, where
        that is most of it, and a course of its own."""
        model = self.model
        moving = [found for name, found in repeated.items() if model.channels[name].floating]
        if not self.separate and any(found.gains_differ for found in moving):
            self.separate = (model.gain,)
            self.calibration = self._calibrated()
        assert self.calibration is not None
        if all(set(e.observed) <= set(repeated) for e in self.experiments):  # no channel tells a circumstance from it
            testable = [e for e in testable if not model.effects[e].circumstance]
        return beyond_what_differs(self._selected(self.calibration, testable, repeated), repeated)

    def _switched(self, fitted: Fit) -> bool:
        """Where a fit shows that the drive switched between two samples of its record: calibrate once more."""
        found = False
        while (moved := switching.settled(fitted)) is not None:
            self.latents = moved
            self.calibration = self._calibrated()
            fitted, found = self.calibration.fit, True
        return found

    def _may_wander(self, found: Selection) -> bool:
        """A room that nobody read is found to drift, or a law of heat without a name is found."""
        room = self.model.roles.room
        heat = any(c.effect == room or (c.definition.free and c.definition.stage == 'thermal') for c in found.chosen)
        return heat and any(e.imposed.unread for e in self.experiments)

    def _where_rooms_wander(self, found: Selection, testable: Sequence[str]) -> Selection:
        """Select once more, with rooms that go their own ways as rooms do: no form of a drift follows them, and physics
        is found in what it misses. As it was where they went farther, and no drift is named for it."""
        assert self.calibration is not None
        if not (work := self.calibration.fit.problem.work).left:
            return found
        self.wandering = True
        again = self._selected(self.calibration, testable)
        usual = wandered(again.final) < _FAR * self.model.surroundings.wander
        whole = bool(again.chosen) or work.left  # one that the work ran out under has nothing to say against the first
        self.wandering = whole and (usual or any(c.effect == self.model.roles.room for c in again.chosen))
        return again if self.wandering else found

    def partial(self) -> Diagnosis:
        if self.calibration is None:
            return self._without_result('insufficient_data', 'interrupted before the calibration was done', True)
        return self._without_result(
            'insufficient_data', 'interrupted: the muscle was calibrated, effects were not selected', True
        )

    def _without_result(self, verdict: str, why: str, partial: bool = False) -> Diagnosis:
        fitted = self.calibration.fit if self.calibration else None
        return Diagnosis(
            headline=f'No verdict: {why}.',
            verdict=verdict,
            recordings=summaries(fitted.problem.followed if fitted else self.experiments),
            noise={name: n.sigma for name, n in quick_noise(self.experiments).items()},
            calibration=calibrated_values(fitted, self.nominal) if fitted else {},
            sensors={},
            location=None,
            findings=(),
            fit={},
            ranking=(),
            not_testable=tuple(NotTestable(e, 'nothing was tested: ' + why) for e in self.model.listed),
            unexplained=None,
            next_experiment=None,
            nominal=self.nominal,
            improved=fitted.muscle if fitted else self.nominal,
            known=self.calibration.known if self.calibration else None,
            calibrated=fitted.muscle if fitted else None,
            rig=beside(self.rig, stated_rig(fitted.muscle if fitted else self.nominal, self.experiments)),
            partial=partial,
            seconds=self.seconds,
        )


def insufficient(experiments: Sequence[Experiment]) -> str | None:
    """Why nothing can be concluded: too few samples, or a drive and a load that never change."""
    samples = max(o.time.size for e in experiments for o in e.observed.values())
    if samples < _LEAST_SAMPLES:
        return f'the longest channel has {samples} samples, at least {_LEAST_SAMPLES} are needed'
    driven = any(np.ptp(e.imposed.drive) > 0.0 and np.max(np.abs(e.imposed.drive)) > 1e-6 for e in experiments)
    if not driven:
        return 'the input never changes, so nothing excites the muscle'
    return None if moving(experiments, _MOVES) else 'no channel moves beyond its noise'


def moving(experiments: Sequence[Experiment], times: float) -> bool:
    """Whether a channel moves by more than so many times its noise."""
    noise = quick_noise(experiments)
    return any(np.ptp(o.value) > times * noise[name].sigma for e in experiments for name, o in e.observed.items())


def skipped(experiments: Sequence[Experiment]) -> dict[str, str]:
    """The effects that are not tried, and why: these recordings cannot show them."""
    fastest = max(_rate(e) for e in experiments)
    blind = all(e.imposed.kind == 'power' and len(e.observed) == 1 for e in experiments)
    loaded = [e for e in experiments if e.holding.hangs]
    moves = any(o.swinging is not None for e in loaded for o in e.observed.values())
    steps = moves or any(np.ptp(e.imposed.load) > 0.0 for e in loaded)
    found = {}
    model = experiments[0].model
    for name in model.listed:
        effect = model.effects[name]
        if effect.circumstance and blind:
            found[name] = 'a power and one output do not tell it from whatever differs between recordings'
        elif fastest < effect.least_rate:
            found[name] = 'these recordings are sampled too slowly to show it'
        elif effect.swings and not steps:
            found[name] = 'a weight swings after a step of the load, and there is none in these recordings'
    return found


def _rate(experiment: Experiment) -> float:
    """How often the densest channel is seen where it is seen best, Hz (averages spare what follows a load step)."""
    densest = max(experiment.observed.values(), key=lambda o: o.time.size)
    return 1.0 / max(float(np.quantile(np.diff(densest.time), 0.05)), 1e-9) if densest.time.size > 1 else 0.0
