"""What an effect is: one physics that the paper leaves out, told to the stages that it touches.

An effect is a set of hooks. Each hook is a plain function ``hook(q, c, p, s, ds)`` that numba compiles:

- ``q``: the quantities of this instant (names in ``quantities.py``), which the hook reads and changes;
- ``c``: the effect's own parameters, in the order of ``parameters``;
- ``p``: the muscle's parameters (``p[INDEX['hA']]``);
- ``s``, ``ds``: the effect's own states and their rates, in the order of ``states``.

The points at which hooks are called, in this order:

=============  ==========================================================================================
begin          at the start of a step, when the inputs may have jumped; may change ``q[TEMPERATURE]``
surroundings   ambient temperature, the source's setting, the core's temperature, before anything else
softening      after the modulus ratio
contraction    after the temperature that drives the contraction and its gain are set
extra          length beside thermal and elastic (``q[EXTRA]``)
elasticity     after the elastic elongation under ``q[FORCE]``
limit          after their sum ``q[LENGTH]``; contraction to limit are called again while a held end seeks its force
position       after the equilibrium length of an end that can move: inertia and friction
resistance     after the resistance
drive          the source's command before it becomes a current
heat           after conductance, capacity and further heat
rates          writes ``ds``; all quantities are known
sensor         what the sensors show
initial        writes ``s`` for a muscle that has long rested at the present temperature and force
commit         at the end of a substep: memories (play, friction) move here
=============  ==========================================================================================

States of an effect without ``rates`` are memories: only ``commit`` and ``begin`` move them.

Off means that no hook is called: the paper's model, bit for bit.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.points import POINTS

SWING = 50.0  # K: warmed by so much and cooled again, a muscle has gone through one cycle
STAGES = ('electrical', 'thermal', 'mechanical', 'sensor')


def _nothing_fast(c: Any, p: Any) -> float:
    return 0.0


@dataclass(frozen=True)
class Column:
    """An array as files and ROS see it. Inside each of its numbers is a parameter: ``members``, in order.

    ``count`` names the parameter that says how many of the members are in use. ``follows``: where it is not given, it
    has the values of that column. ``rising``: each number is above the one before.
    """

    name: str
    unit: str
    meaning: str
    members: tuple[str, ...]
    count: str
    follows: str = ''
    rising: bool = False


@dataclass(frozen=True)
class Freedom:
    """What a fit needs to know of a law without a name (the fit itself: ``muscle/free_basis.py``).

    ``drivers``: name and unit of what the law may depend on, in the order of its parameter ``driver``. ``width``: the
    standard deviation of the law's values before anything is known, in the unit of its values; ``bend``: that of the
    second differences between values at knots that lie a quarter of the driver's range apart. ``lag``: the parameter
    that is the time in which the law is reached, where one is. ``by_loads``: under one and the same load it does what
    another law does to the length, so that only different loads tell it. ``untried``: drivers that a diagnosis does not
    try. ``of``: what its values are of, in words, where the name of the law says something else.
    """

    drivers: Mapping[str, str]
    width: float
    bend: float
    lag: str = ''
    by_loads: bool = False
    untried: frozenset[str] = frozenset()
    of: str = ''


@dataclass(frozen=True)
class Effect:
    """One effect: its name in parameters and reports, its row in the catalogue, and its hooks.

    ``fastest_rate(c, p)`` (1/s) tells the stepper how quick its quickest state is. ``strength`` names the
    parameter that switches it off at its value ``none`` (the amplitude that a fit lets grow). ``motion``: its
    ``heat`` needs ``q[VELOCITY]`` or ``q[FORCE_RATE]``, which depend on the heating they change. ``circumstance``: it
    is no property of the muscle but of the room or the rig at the time, and may differ from recording to recording.
    ``moments``: its parameters that are instants or spans of a recording; ``whole``: one that is a recording's length;
    ``age``: one that says what the muscle went through before it. ``unexpected``: none is known of this fibre in
    the model's domain, so that of two that explain the same the other is named. ``one_way``: what causes it moves it
    from ``none`` towards the usual value, hardly ever the other way. ``listed``: the diagnosis may name it. ``chance``:
    its instants are chance, so that it has no slope for a fit to follow. ``columns``: which of its parameters are the
    numbers of an array. ``prepare(c)`` fills the ``prepared`` numbers that stand behind its parameters in ``c``.
    ``stage_by``: the parameter whose choice is its stage, where it may be of several. ``free``: it has no name.

    What a diagnosis asks of it: ``hidden``: why recordings of one muscle never show it by its usual choices, with which
    it is not tried. ``least_rate``: sampled more slowly (Hz) none shows it. ``latent``: what of it no equation
    foretells, so that a fit infers it: a ``course`` of the conductance or the ``room`` in time, or ``slips`` at
    instants of their own, whose mean it is. ``threshold``: the parameter below which it does nothing. ``swings``: it
    lets a weight swing after a step of the load. ``sticks``: it holds and lets go by itself. ``like_slips``: slips that
    are too small to be seen, or fall together with an input's step, pass for it. ``late``: its parameters for the
    delay, the pace and the channel, where it makes one channel late. ``delay(muscle)``: by how much (s) it makes
    something follow, which samples must resolve.
    """

    name: str
    row: str
    stage: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    hooks: Mapping[str, Callable[..., None]]
    strength: str
    none: float = 0.0
    states: tuple[str, ...] = ()
    fastest_rate: Callable[[Any, Any], float] = field(default=_nothing_fast)
    motion: bool = False
    circumstance: bool = False
    moments: tuple[str, ...] = ()
    whole: str = ''
    age: str = ''
    unexpected: bool = False
    one_way: bool = False
    listed: bool = True
    chance: bool = False
    columns: tuple[Column, ...] = ()
    prepared: int = 0
    prepare: Callable[[Any], None] | None = None
    stage_by: str = ''
    free: Freedom | None = None
    hidden: str = ''
    least_rate: float = 0.0
    latent: str = ''
    threshold: str = ''
    swings: bool = False
    sticks: bool = False
    like_slips: bool = False
    late: tuple[str, str, str] | None = None
    delay: Callable[[Any], float] | None = None

    @property
    def of_muscle(self) -> bool:
        """Whether it is physics of the muscle: no fault of an instrument, and nothing of the room or the rig then."""
        return self.stage != 'sensor' and not self.circumstance

    @property
    def fitted(self) -> tuple[Parameter, ...]:
        """The parameters that a fit moves."""
        return tuple(row for row in self.parameters if row.fitted and not row.state)

    def moved(self, values: Mapping[str, float]) -> tuple[Parameter, ...]:
        """The parameters that a fit moves with the choices in ``values`` (their keys: ``effect.parameter``)."""

        def used(row: Parameter) -> bool:
            return row.only is None or round(values[f'{self.name}.{row.only[0]}']) == row.only[1]

        return tuple(row for row in self.fitted if used(row))

    def __post_init__(self) -> None:
        unknown = set(self.hooks) - set(POINTS)
        if unknown or self.stage not in STAGES:
            raise ValueError(f'{self.name}: unknown hook or stage: {unknown or self.stage}')
