"""Numbers as people read them: few digits, and as many as an interval needs for its bounds to be told apart."""

from math import floor, isfinite, log10

from tcp_muscle_ros.diagnosis.answer.findings import Value

_MOST = 12  # decimals or digits that are worth printing


def number(value: float, digits: int = 3) -> str:
    """Few digits, never NaN: ``-`` where there is none."""
    if not isfinite(value):
        return '-'
    if value != 0.0 and 1e-3 <= abs(value) < 1e6:
        return f'{value:.{max(0, digits - 1 - floor(log10(abs(value))))}f}'
    return f'{value:.{digits}g}'


def digits_text(value: Value) -> tuple[str, str, str]:
    """Value, low and high with the digits that the interval's width leaves worth reading, the same for all three."""
    numbers, width = (value.value, value.low, value.high), value.high - value.low
    largest = max((abs(x) for x in numbers if isfinite(x)), default=0.0)
    if not (isfinite(width) and width > 0.0):
        first, second, third = (number(x) for x in numbers)
    elif 1e-3 <= largest < 1e6:
        decimals = min(max(1 - floor(log10(width)), 0), _MOST)
        first, second, third = (f'{x:.{decimals}f}' if isfinite(x) else '-' for x in numbers)
    else:
        digits = min(max(2 + floor(log10(largest)) - floor(log10(width)), 3), _MOST)
        first, second, third = (number(x, digits) for x in numbers)
    return first, second, third


def value_text(value: Value) -> str:
    """``0.100 (0.092 to 0.108) N/m``: a value with its 90 % interval, where it has one, and unit (none for a
    pure number)."""
    middle, low, high = digits_text(value)
    interval = f' ({low} to {high})' if isfinite(value.low) and isfinite(value.high) and value.low < value.high else ''
    return f'{middle}{interval}' + (f' {value.unit}' if value.unit not in ('', '1') else '')
