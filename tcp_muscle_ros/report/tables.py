"""Tables for the terminal."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite

from tcp_muscle_ros.diagnosis.answer.digits import digits_text
from tcp_muscle_ros.diagnosis.answer.findings import Value
from tcp_muscle_ros.diagnosis.answer.replaying import Comparison, Own
from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, Estimate
from tcp_muscle_ros.muscle import SPECIFICATIONS, ZERO_CELSIUS
from tcp_muscle_ros.report.as_read import SHOWN
from tcp_muscle_ros.settings.parameter_file import describe

_NEAR = 0.1  # of what is nominal


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns aligned: the first to the left, the others to the right."""
    widths = [max(len(row[k]) for row in [heads, *rows]) for k in range(len(heads))]

    def line(row: Sequence[str]) -> str:
        return '  '.join(
            cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        )

    return '\n'.join([line(heads), '  '.join('-' * w for w in widths), *(line(row) for row in rows)])


def comparison_table(compared: Mapping[str, Comparison]) -> str:
    """One row a channel: samples, RMSE, NRMSE (of the recorded peak to peak), bias."""
    rows = []
    for name, c in compared.items():
        unit, factor = SHOWN[name]
        rows.append(
            [
                name,
                str(c.time.size),
                f'{c.rmse * factor:.4g} {unit}',
                f'{100.0 * c.nrmse:.2f} %' if isfinite(c.nrmse) else '-',
                f'{c.bias * factor:+.4g} {unit}',
            ]
        )
    return table(['channel', 'samples', 'RMSE', 'NRMSE', 'bias'], rows)


_MODELS_ZERO = (
    'note: the model has its zero of displacement at the length at which it hangs at rest at T0 under the first load. '
    'That depends on k0 and the load, and the recording has its zero elsewhere: this need not be an offset of an '
    'instrument'
)


def own_note(own: Own) -> str:
    """What was fitted to a recording because it is its own."""
    said = [] if own.ambient is None else [f'the room {own.ambient - ZERO_CELSIUS:.2f} degC']
    said += [f'the start {own.start - ZERO_CELSIUS:.2f} degC']
    for name, zero in own.zeros.items():
        unit, factor = SHOWN[name]
        said += [f'{name} {zero * factor:+.3g} {unit} where the model has its zero']
    said += [f'{name} {value:.2g}' for name, value in own.states.items()]
    if own.switches:
        said += [f'when the drive switched between two samples ({len(own.switches)} times)']
    told = f'fitted to this recording only: {", ".join(said)} (--as-given takes them as stated)'
    return f'{told}\n{_MODELS_ZERO}' if 'displacement' in own.zeros else told


def unfixed(value: float, nominal: float, shown: str) -> str:
    """What became of a parameter that the data do not fix: it stayed, or went with others to what is ``shown``."""
    stayed = abs(value - nominal) <= _NEAR * abs(nominal)
    return 'kept near its nominal value' if stayed else f'{shown} is one of many that fit'


def _edge(e: Estimate, value: float) -> float:
    row = SPECIFICATIONS.get(e.name)
    if row is not None:
        return row.to_edge(value)
    return value - ZERO_CELSIUS if e.unit == 'K' else value


def _row(e: Estimate, handed: float) -> list[str]:
    """Its row in the table; ``handed``: the value that the calibrated muscle has."""
    name = e.name if e.recording is None else f'{e.name} [{e.recording + 1}]'
    unit = 'degC' if e.unit == 'K' else e.unit
    if not e.fixed:
        alone = f' (only together with {e.partner})' if e.partner else ''
        why = f'not fixed by the data{alone}; {unfixed(handed, e.nominal, f"{_edge(e, handed):.4g}")}'
        return [name, f'{_edge(e, e.nominal):.4g}', '-', '-', unit, why]
    remark = 'at its bound' if e.at_bound else ''
    value, low, high = (f'{_edge(e, x):.5g}' for x in (e.value, e.low, e.high))
    if low == high:
        value, low, high = digits_text(Value(_edge(e, e.value), _edge(e, e.low), _edge(e, e.high), unit))
    return [name, f'{_edge(e, e.nominal):.5g}', value, f'{low} to {high}', unit, remark]


def calibration_table(calibration: Calibration) -> str:
    """Parameters with 90 % intervals, those that the data do not fix said to be so, and the misfit by channel."""
    muscle = calibration.parameters
    found = (*calibration.estimates, *calibration.combinations)
    rows = [_row(e, muscle[e.name] if e.recording is None and e.name in muscle else e.value) for e in found]
    lines = [table(['parameter', 'nominal', 'value', '90 % interval', 'unit', 'remark'], rows), '']
    if any(e.name == 'B' for e in calibration.estimates):
        lines.append('note: recordings determine only the products B c1 and B c2; c1 is kept at its nominal value')
    if calibration.held_by_melting:
        lines.append(
            'note: the fit would heat the fibre beyond 220 degC, where nylon is close to melting; hA and the gain are '
            'set by this limit, not by the data'
        )
    for name, errors in calibration.rmse().items():
        unit, factor = SHOWN[name]
        shown = ', '.join('-' if e != e else f'{e * factor:.4g}' for e in errors)
        lines.append(f'RMSE {name}: {shown} {unit}')
    return '\n'.join(lines)


def calibration_note(calibration: Calibration) -> Callable[[str], str]:
    """The comment behind each parameter of a calibrated file."""
    estimates = {e.name: e for e in calibration.estimates if e.recording is None}

    def note(name: str) -> str:
        e = estimates.get(name)
        if e is None:
            return describe(name)
        row = SPECIFICATIONS[name]
        if not e.fixed:
            return f'{row.edge_unit}; {row.meaning}; not fixed by the data'
        return f'{row.edge_unit}; {row.meaning}; calibrated, 90 % {row.to_edge(e.low):.5g} to {row.to_edge(e.high):.5g}'

    return note
