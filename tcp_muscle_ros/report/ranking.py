"""The ranking of the candidates in words: what was found, what explains as much, what a part, what little."""

from collections.abc import Sequence

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Ranked
from tcp_muscle_ros.report.words import percent, plain

_PART = 0.2  # of what the best explains: less is little
_NAMED = 6  # of each kind


def ranking_words(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Pairs of a heading and what belongs below it. Empty where nothing was ranked.

    Shares are of what the best explains alone; what was found beside it may explain little alone.
    """
    ranking = [r for r in diagnosis.ranking if r.gain > 0.0]
    if not ranking:
        return []
    best = max(r.gain for r in ranking)
    found = [f.effect for f in diagnosis.findings]
    rivals = [other for f in diagnosis.findings for other in f.indistinguishable_from if other not in found]
    rest = [r for r in ranking if r.effect not in (*found, *rivals)]
    part = [r for r in rest if r.gain >= _PART * best]
    behind = [r for r in rest if r.gain < _PART * best]
    said = [
        (
            'Found',
            ', '.join(map(plain, found)) or 'nothing: no effect explains enough and predicts unseen data better, too',
        ),
        ('Explains as much', ', '.join(map(plain, dict.fromkeys(rivals))) or 'nothing else'),
        ('Explains a part of it alone', _shares(part, best) or 'nothing else'),
        ('Explains little', _shares(behind, best)),
    ]
    if not found:
        del said[1]
    return [(heading, text) for heading, text in said if text]


def _shares(ranked: Sequence[Ranked], best: float) -> str:
    named = [f'{plain(r.effect)} ({percent(min(r.gain / best, 1.0))})' for r in ranked[:_NAMED]]
    more = len(ranked) - len(named)
    return ', '.join(named) + (f' and {more} more' if more else '')
