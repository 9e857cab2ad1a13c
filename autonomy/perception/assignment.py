"""Which detection belongs to which track: the cheapest pairs first, each row and column once. Pure.

Greedy, not optimal: with gates far smaller than the gaps between things the two agree; where people brush past each
other a swap of identities changes neither place nor velocity by more than the gate.
"""

from collections.abc import Iterable


def cheapest_pairs(costs: Iterable[tuple[float, int, int]]) -> dict[int, int]:
    """{row: column} of the accepted pairs. costs: (cost, row, column) of every pair inside its gate."""
    pairs: dict[int, int] = {}
    taken: set[int] = set()
    for _, row, column in sorted(costs):
        if row not in pairs and column not in taken:
            pairs[row] = column
            taken.add(column)
    return pairs
