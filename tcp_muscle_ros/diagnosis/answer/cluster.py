"""Causes that look alike: one cluster with a probability for each member, which add up to one.

With power in and one channel out, causes in different stages look alike: a supply that lags, a core that lags, a clock.
One of them is the finding, and its share says how much it leads; the others are told beside it.
"""

from tcp_muscle_ros.diagnosis.answer.findings import Member
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.search.selected import Chosen

_LEAST = 0.02  # a member that is less probable is not told


def cluster(chosen: Chosen) -> tuple[Member, ...]:
    """An effect and what competed for its place, the most probable first; none where nothing did."""
    kept = [
        (share, r)
        for share, r in zip(chosen.shares, chosen.rivals, strict=True)
        if share >= _LEAST or r.effect == chosen.effect
    ]
    if len(kept) < 2:
        return ()
    total = sum(share for share, _ in kept)
    found = [Member(r.effect, r.definition.stage, float(share / total)) for share, r in kept]
    return tuple(sorted(found, key=lambda member: -member.probability))


def one_channel(problem: Problem) -> bool:
    """Whether the recordings show one output only."""
    return len(set().union(*(e.observed for e in problem.experiments))) == 1
