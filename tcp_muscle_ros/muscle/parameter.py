"""One number of the model: its value, unit, bounds, meaning and source, written once."""

from dataclasses import dataclass

ZERO_CELSIUS = 273.15  # K
GRAVITY = 9.80665  # m/s^2, the standard one


@dataclass(frozen=True)
class Parameter:
    """A parameter in SI. ``absolute`` marks an absolute temperature: K inside, degC at the edge.

    ``choices``: the value is the place of one of these names; ``spelled``: people and ROS write that name. ``fitted``
    False: a fit leaves it as it is. ``crossed``: the output (a name of Outputs) that has to cross this value for the
    effect to begin or end; ``around``: the parameter of the same effect that says how far from there it is felt.
    ``bends``: a fit moves it from its usual value, at which the effect is sought. ``state``: it is that of
    the muscle where a recording begins; each has its own, and 0 is a muscle that has long rested. ``only``: the name of
    a parameter of the same effect, and the choice of it without which this one does nothing. ``told_by``: what is
    imposed on the muscle (``load``) that has to differ for its choices to be told apart.
    """

    name: str
    value: float
    unit: str
    low: float
    high: float
    meaning: str
    source: str
    absolute: bool = False
    choices: tuple[str, ...] = ()
    fitted: bool = True
    crossed: str = ''
    around: str = ''
    spelled: bool = False
    bends: bool = False
    state: bool = False
    only: tuple[str, int] | None = None
    told_by: str = ''

    @property
    def edge_unit(self) -> str:
        """The unit in which people and ROS see it."""
        return 'degC' if self.absolute else self.unit

    def to_edge(self, value: float) -> float:
        """An inside value as people and ROS see it; K -> degC rounded where the subtraction leaves dust."""
        return round(value - ZERO_CELSIUS, 9) if self.absolute else value

    def from_edge(self, value: float) -> float:
        """A value from a file or ROS as the model sees it."""
        return value + ZERO_CELSIUS if self.absolute else value

    @property
    def edge_value(self) -> float:
        """The default at the edge."""
        return self.to_edge(self.value)

    @property
    def edge_low(self) -> float:
        """The lower bound at the edge."""
        return self.to_edge(self.low)

    @property
    def edge_high(self) -> float:
        """The upper bound at the edge."""
        return self.to_edge(self.high)
