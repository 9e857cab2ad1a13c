"""The one table of what must be right, and the fast tests that hold it: branch coverage and mutation both go by it.

Mutation leaves out those that are not `mutated`, unless they are named: their tests hold the branches, but not yet every mutant.
"""

from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]


class Subject(NamedTuple):
    source: str
    tests: tuple[str, ...]  # its own, seconds together; a mutant is held against these alone
    mutated: bool = True


def _gateway(source: str, *tests: str, mutated: bool = True) -> Subject:
    return Subject(f"vehicle_gateway/{source}.py", tuple(f"tests/vehicle_gateway/test_{test}.py" for test in tests), mutated)


SUBJECTS = (
    _gateway("authority", "authority", "authority_parts"),
    _gateway("failsafe", "limits", "failsafe", "failsafe_parts", "tables"),
    _gateway("gate", "limits", "gate_names", "gate"),
    _gateway("lease", "lease_asker", "lease_commands", "lease"),
    Subject(
        "vehicle_gateway/succession.py",
        (
            "tests/vehicle_gateway/test_succession.py",
            "tests/safety/test_next_operator_rules.py",
            "tests/safety/test_next_operator_leases.py",
        ),
    ),
    _gateway("hand_over", "limits", "hand_over_words", "hand_over"),
    _gateway("can/e2e", "can_e2e", "can_e2e_both_ways"),
    _gateway("can/layout", "can_layout", "can_dbc", "can_codec", "can_cyclic"),
    _gateway("can/codec", "can_codec", "can_dbc", "can_cyclic", "can_transmit"),
    _gateway("can/actuator_codec", "can_codec", "can_plant", "ecu"),
    _gateway("can/ecu_codec", "can_codec", "ecu"),
    _gateway("can/health_codec", "health_codec"),
    _gateway("can/watch_codec", "watch_codec"),
    _gateway("can/toyota_codec", "toyota_codec", "toyota_limits"),
    _gateway("can/toyota_feedback", "toyota_codec", "toyota_limits"),
    _gateway("can/toyota_layout", "toyota_codec", "toyota_limits"),
    _gateway("rolling", "rolling", mutated=False),
    _gateway("safe_stop", "safe_stop", mutated=False),
    _gateway("guard", "guard", "sweep", mutated=False),
    _gateway("guarding", "guard", "cycle_stops", mutated=False),
    _gateway("zones", "zones", mutated=False),
    _gateway("zoning", "zones", "zones_driven", "guard", mutated=False),
)


def chosen(names: list[str]) -> tuple[Subject, ...]:
    """The subjects whose path contains one of the names; all without names. Raises SystemExit when a name fits none."""
    for name in names:
        if not any(name in subject.source for subject in SUBJECTS):
            raise SystemExit(f"{name}: no such file in the table; there are: {', '.join(s.source for s in SUBJECTS)}")
    return tuple(subject for subject in SUBJECTS if not names or any(name in subject.source for name in names))
