"""Cases and suites: what is concealed in which muscle, on which bench, under which experiments. All from one seed."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from proof.protocols import Lab, draw_lab, experiment, plan
from proof.recordings import Noise, draw_noise
from proof.truth import EFFECTS, Bench, Body, Concealed, Experiment, Signals, conceal, draw_body, observe

# The number of the form that an effect takes. 'varied' is for development too: what is tuned on one form alone is tuned
# to that form. On 'outside' nothing is tuned, and the weights of the probabilities are fitted: a diagnosis is surer of
# forms that it was tuned on than of those that it meets.
SUITES = {'development': 0, 'sealed': 1, 'varied': 2, 'outside': 3}
FULL = {'single': 120, 'double': 60, 'triple': 20, 'null': 100, 'decoy': 80, 'unlisted': 20, 'ambiguous': 30}

INVISIBLE = ('contact_resistance',)  # on one muscle
SENSORS = (
    'thermocouple_lag', 'thermocouple_gain', 'temperature_offset', 'displacement_drift', 'displacement_offset',
    'clock_skew', 'current_gain', 'thermocouple_pickup',
)  # fmt: skip
PHYSICS = tuple(
    name for name, entry in EFFECTS.items() if entry.listed and entry.stage != 'sensor' and name not in INVISIBLE
)
UNLISTED = (
    ('periodic_friction', 'stiffness_switch', 'rate_stroke', 'peltier', 'varistor'),
    ('current_stroke', 'self_resonance', 'resistance_jump', 'boiling_film', 'other_logger', 'cubic_softening'),
    ('seebeck_voltage', 'hunting_supply', 'touching_rail', 'slow_stroke', 'sticky_turns', 'loosening_bead'),
    ('healing_coat', 'pressed_to_guide', 'worked_soft', 'overloaded_turns', 'aliased_hum'),
)
# Unlisted too, of the kind that a curve over one quantity could describe. No suite draws from it.
EXPRESSIBLE = (
    'wicking_coat', 'reorganising_crystals', 'percolating_coat',
    'reentrant_phase', 'gelling_resin', 'relaxing_untwist',
)  # fmt: skip
DECOYS = ('wrong_parameters', 'coloured_noise', *SENSORS)
BASE = ('R0', 'a_R', 'C', 'hA', 'k0', 'H0', 'B')  # the parameters that a muscle has for itself

# Pairs that the given experiments cannot tell apart: (one, the other, experiments, channels that are missing).
AMBIGUOUS: tuple[tuple[str, str, tuple[str, ...], tuple[str, ...]], ...] = (
    ('heat_capacity', 'latent_heat', ('repeat', 'repeat'), ()),
    ('natural_convection', 'radiation', ('repeat', 'repeat'), ()),
    ('exposed_area', 'natural_convection', ('one_load', 'one_load'), ()),
    ('resistance_strain', 'tcr_curvature', ('one_load', 'one_load'), ()),
    ('viscous_flow', 'torsional_leakage', ('one_load', 'one_load'), ()),
    ('hysteresis', 'friction', ('one_load', 'one_load'), ()),
    ('thermocouple_lag', 'clock_skew', ('rates', 'rates'), ()),
)


@dataclass
class Case:
    """All that a case is; its recordings and its label are made from it."""

    name: str
    kind: str
    what: str  # the effect, decoy or pair that was asked for
    seed: list[int]
    lab: Lab
    bench: Bench
    experiments: list[Experiment]
    channels: tuple[str, ...]
    noise: dict[str, Noise]
    concealed: list[Concealed] = field(default_factory=list)
    nominal: dict[str, float] = field(default_factory=dict)  # written as a parameter file where not empty
    verdicts: tuple[str, ...] = ('match', 'wrong_parameters')  # that are right
    partner: str = ''  # what an ambiguous case cannot be told from
    form: int = 0  # of what is concealed, as the suite has it

    def rng(self, stream: int) -> np.random.Generator:
        """A stream of random numbers of its own."""
        return np.random.default_rng([*self.seed, 1000 + stream])

    def without(self, effect: str) -> Bench:
        """The same bench with one of the effects left out."""
        bench = Bench.of(self.lab.body)
        for concealed in self.concealed:
            if concealed.effect != effect:
                concealed.change(bench)
        return bench


def signals_of(case: Case, bench: Bench | None = None) -> list[Signals]:
    """What ideal instruments would have shown in each recording of a case (or of another bench in its place)."""
    signals: list[Signals] = []
    for k, done in enumerate(case.experiments):
        signals.append(observe(bench or case.bench, done, k, signals[-1].dose if signals else 0.0))
    return signals


def composition(suite: str, cases: int, seed: int, kinds: Sequence[str] = tuple(FULL)) -> list[tuple[str, str]]:
    """(kind, what) of each case, in an order that says nothing. cases = 0: the full suite, or all of these kinds."""
    rng = np.random.default_rng([seed, zlib.crc32(suite.encode())])
    full = {kind: n for kind, n in FULL.items() if kind in kinds}
    total = sum(full.values())
    counts = dict(full) if cases in (0, total) else {k: int(n * cases / total) for k, n in full.items()}
    for kind in sorted(full, key=lambda k: -(full[k] * cases / total % 1)):
        if 0 < cases != sum(counts.values()):
            counts[kind] += 1
    form = SUITES[suite]
    pools: dict[str, Sequence[str]] = {
        'single': PHYSICS,
        'decoy': DECOYS,
        'unlisted': UNLISTED[form],
        'ambiguous': [str(k) for k in range(2 * len(AMBIGUOUS))],
    }
    wanted: list[tuple[str, str]] = []
    for kind, count in counts.items():
        names = in_turns(rng, pools[kind], count) if kind in pools else [''] * count
        wanted += [(kind, name) for name in names]
    rng.shuffle(wanted)
    return [(str(kind), str(what)) for kind, what in wanted]


def in_turns(rng: np.random.Generator, names: Sequence[str], count: int) -> list[str]:
    """Every name as often as any other."""
    chosen: list[str] = []
    while len(chosen) < count:
        chosen += [str(name) for name in rng.permutation(names)]
    return chosen[:count]


def make_case(suite: str, seed: int, number: int, kind: str, what: str) -> Case:
    """The case of this number. Deterministic in its arguments."""
    form = SUITES[suite]
    seeds = [seed, zlib.crc32(suite.encode()), number]
    rng = np.random.default_rng(seeds)
    body = draw_body(rng)
    lab = draw_lab(rng, body, plain=kind == 'ambiguous')
    if kind == 'ambiguous':
        return _ambiguous(f'case_{number:04d}', seeds, rng, lab, int(what), form)
    names, nominal, verdicts = _what(kind, what, rng, body)
    if kind == 'null' and number % 2:  # this lab knows its muscle, the others believe the default's numbers
        nominal, verdicts = own_numbers(body), ('match',)
    # singles reach below the catalogue's ranges, so that the power curve has a foot
    weakest = {'single': -0.25, 'unlisted': 0.2}.get(kind, 0.0)
    concealed = [conceal(name, float(rng.uniform(weakest, 1.0)), form, body, rng) for name in names]
    if names:
        menus = [EFFECTS[name].shown_by for name in names]
    else:  # as if something were looked for, so that the experiments give nothing away
        menus = [EFFECTS[str(rng.choice(PHYSICS))].shown_by]
    experiments = _experiments(lab, menus, rng)
    bench = Bench.of(body)
    for hidden in concealed:
        hidden.change(bench)
    return Case(
        name=f'case_{number:04d}',
        kind=kind,
        what=what,
        seed=seeds,
        lab=lab,
        bench=bench,
        experiments=experiments,
        channels=_channels(rng, names),
        noise=draw_noise(rng, coloured=what == 'coloured_noise'),
        concealed=concealed,
        nominal=nominal,
        verdicts=verdicts,
        form=form,
    )


def _what(
    kind: str, what: str, rng: np.random.Generator, body: Body
) -> tuple[list[str], dict[str, float], tuple[str, ...]]:
    """Names of the effects, nominal parameters and the right verdicts of a kind of case."""
    if kind == 'null':
        return [], {}, ('wrong_parameters',)
    if kind == 'decoy':
        if what == 'wrong_parameters':
            return [], wrong_parameters(rng, body), ('wrong_parameters',)
        if what == 'coloured_noise':
            return [], {}, ('match', 'wrong_parameters')
        return [what], {}, ('sensor_or_setup', *_quiet(what))
    if kind == 'unlisted':
        return [what], {}, ('unexplained',)
    if kind == 'beside':  # an unlisted effect beside a listed one
        return what.split('+'), {}, ('missing_physics', 'unexplained')
    count = {'single': 1, 'double': 2, 'triple': 3}[kind]
    names = [what] if kind == 'single' else [str(n) for n in rng.choice(PHYSICS, count, replace=False)]
    return names, {}, ('missing_physics',)


def own_numbers(body: Body) -> dict[str, float]:
    """The parameter file of a lab that has measured its muscle: nothing in it is wrong."""
    return {name: float(f'{getattr(body, name):.9g}') for name in BASE}


def _quiet(what: str) -> tuple[str, ...]:
    """Faults that a change of parameters hides (a gain of the ammeter is a gain of the heating)."""
    return ('wrong_parameters',) if what in ('current_gain', 'thermocouple_gain', 'displacement_offset') else ()


def wrong_parameters(rng: np.random.Generator, body: Body) -> dict[str, float]:
    """A nominal parameter file that is wrong: the paper's own 0.15 W/K, or several numbers far off."""
    if rng.random() < 0.4:
        return {'hA': 0.15}
    wrong = {'hA': body.hA, 'C': body.C, 'R0': body.R0, 'a_R': body.a_R, 'k0': body.k0}
    chosen = [str(name) for name in rng.choice(list(wrong), int(rng.integers(1, 4)), replace=False)]
    return {name: float(f'{wrong[name] * np.exp(rng.choice([-1, 1]) * rng.uniform(0.25, 0.8)):.4g}') for name in chosen}


def _experiments(lab: Lab, menus: list[tuple[str, ...]], rng: np.random.Generator) -> list[Experiment]:
    if len(menus) == 1:
        return plan(lab, menus[0], rng)
    each = [experiment(lab, str(rng.choice(menu)), rng) for menu in menus]
    return each + plan(lab, menus[0], rng, count=2)[: 4 - len(each)]


def _channels(rng: np.random.Generator, names: list[str]) -> tuple[str, ...]:
    """What was recorded: mostly all, now and then without thermometer, without R, or the stroke alone."""
    stages = {EFFECTS[name].stage for name in names}
    everything = ('temperature', 'resistance', 'displacement')
    luck = rng.random()
    if stages & {'sensor'} or luck < 0.82:
        return everything
    if luck < 0.92:
        return everything[1:]
    if 'electrical' in stages:
        return everything
    if luck < 0.96 or 'thermal' in stages:
        return ('temperature', 'displacement')
    return ('displacement',)


def _ambiguous(name: str, seeds: list[int], rng: np.random.Generator, lab: Lab, which: int, form: int) -> Case:
    one, other, protocols, missing = AMBIGUOUS[which // 2]
    hidden, partner = (one, other) if which % 2 == 0 else (other, one)
    weak = hidden in ('radiation', 'tcr_curvature')
    concealed = conceal(hidden, float(rng.uniform(0.7, 1.0) if weak else rng.uniform(0.3, 0.6)), form, lab.body, rng)
    bench = Bench.of(lab.body)
    concealed.change(bench)
    stage = EFFECTS[hidden].stage
    return Case(
        name=name,
        kind='ambiguous',
        what=str(which),
        seed=seeds,
        lab=lab,
        bench=bench,
        experiments=[experiment(lab, protocol, rng) for protocol in protocols],
        channels=tuple(c for c in ('temperature', 'resistance', 'displacement') if c not in missing),
        noise=draw_noise(rng),
        concealed=[concealed],
        verdicts=('missing_physics', *(('sensor_or_setup',) if 'sensor' in (stage, EFFECTS[partner].stage) else ())),
        partner=partner,
        form=form,
    )
