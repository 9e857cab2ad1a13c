"""Who may ask for the lease at all, rule by rule and at each limit; what a lease says of its holder."""

import pytest
from msgspec.structs import replace

from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import Lease, refuse_asker, renew_epoch, request_lease, without_holder
from wire.messages.session import LeaseRequest

S, MS = 1_000_000_000, 1_000_000
NOW = 3_600 * S
ANN = Identity(name="tower-ann", operator="ann", fingerprint="f", ends_ns=NOW + 100 * S)
ASKED = LeaseRequest(operator="ann", session="s1", sent_ns=0, echoed_vehicle_ns=NOW, echoed_boot_id="boot")
FREE = Lease(epoch=7)
HELD = Lease(epoch=7, holder="ann", session="s1", seen_ns=NOW, certificate="tower-ann", fingerprint="f", ends_ns=ANN.ends_ns)
OLD = "the question is too old: ask again"
EXPIRES = "your certificate expires now, or the car's: renew it"


@pytest.mark.parametrize(
    ("lease", "changes", "identity", "rule"),
    [
        (FREE, {}, ANN, ""),
        (FREE, {}, replace(ANN, operator=""), ""),
        (FREE, {}, replace(ANN, rule="revoked"), "revoked"),
        (FREE, {"echoed_boot_id": "", "echoed_vehicle_ns": 0}, Identity(), ""),
        (FREE, {"operator": "bob"}, ANN, "this is the certificate of ann: set [tower.cockpit] operator"),
        (FREE, {"echoed_boot_id": "another"}, ANN, OLD),
        (FREE, {"echoed_vehicle_ns": NOW - 500 * MS}, ANN, ""),
        (FREE, {"echoed_vehicle_ns": NOW - 500 * MS - 1}, ANN, OLD),
        (FREE, {"echoed_vehicle_ns": NOW + 1}, ANN, OLD),
        (HELD, {"echoed_vehicle_ns": NOW - 5 * S}, ANN, ""),
        (HELD, {"echoed_vehicle_ns": NOW - 5 * S - 1}, ANN, OLD),
        (HELD, {"echoed_vehicle_ns": NOW - 5 * S, "session": "s2"}, ANN, OLD),
        (FREE, {}, replace(ANN, ends_ns=NOW + 10 * S + 1), ""),
        (FREE, {}, replace(ANN, ends_ns=NOW + 10 * S), EXPIRES),
    ],
)
def test_who_may_ask_by_rule_and_at_each_limit(lease, changes, identity, rule):
    assert refuse_asker(lease, replace(ASKED, **changes), identity, "boot", NOW) == rule


def test_a_granted_lease_says_whose_it_is_until_when():
    lease, rule = request_lease(FREE, ASKED, NOW, False, ANN)
    assert (lease, rule) == (replace(HELD, epoch=8), "")
    assert lease.owner == ("ann", "s1", "tower-ann")


def test_a_renewal_keeps_the_epoch_and_takes_the_newer_certificate():
    newer = replace(ANN, fingerprint="g", ends_ns=ANN.ends_ns + S)
    lease, rule = request_lease(HELD, ASKED, NOW + S, True, newer)
    assert (lease, rule) == (replace(HELD, seen_ns=NOW + S, fingerprint="g", ends_ns=newer.ends_ns), "")


@pytest.mark.parametrize(
    ("holder", "patience", "silent_ns", "in_use", "granted"),
    [
        ("ann", "0.5", 500 * MS, False, True),
        ("ann", "0.5", 500 * MS - 1, False, False),
        ("ann", "0.5", 60 * S, True, False),
        ("bob", "5", 5 * S, False, True),
        ("bob", "5", 5 * S - 1, False, False),
        ("bob", "5", 60 * S, True, False),
    ],
)
def test_a_silent_holder_is_waited_for_half_a_second_if_it_is_his_own_tower_and_five_otherwise(
    holder, patience, silent_ns, in_use, granted
):
    lease = replace(HELD, holder=holder, certificate=f"tower-{holder}", session="s0")
    after, rule = request_lease(lease, ASKED, NOW + silent_ns, in_use, ANN)
    refused = f"the lease is held by {holder}; it is offered when its holder is silent for {patience} s"
    assert rule == ("" if granted else refused)
    assert after == (replace(HELD, epoch=8, seen_ns=NOW + silent_ns) if granted else lease)


def test_nobody_without_a_name_gets_it_and_it_ends_with_an_epoch_of_its_own():
    assert request_lease(FREE, replace(ASKED, operator=""), NOW, False, ANN) == (
        FREE,
        "an operator needs a name: set [tower.cockpit] operator",
    )
    assert renew_epoch(HELD) == replace(HELD, epoch=8)
    assert without_holder(HELD) == Lease(epoch=8)
    assert Lease() == Lease(epoch=0, holder="", session="", seen_ns=0, certificate="", fingerprint="", ends_ns=0)
