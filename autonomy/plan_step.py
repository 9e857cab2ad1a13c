"""One plan of the stack, every 100 ms: how fast by the braking planner, how among people by the topology planner, how long without
getting on. Pure.
"""

from dataclasses import replace

from msgspec import structs

from autonomy.control.mpcc.reference import of_trajectory
from autonomy.inputs import Inputs
from autonomy.planning.among_people import around, capped
from autonomy.planning.braking_planner import Plan, Situation, plan
from autonomy.planning.horizon import PLAN_PERIOD_S, Predictions
from autonomy.planning.route import Shift, own_lane
from autonomy.planning.topology import Decision, TopologyState
from autonomy.planning.topology import plan as plan_topology
from autonomy.reports import STANDS_M_S
from autonomy.state import Place, Setup, StackState, Way
from autonomy.uncertainty.waiting import wait_on

PLAN_NS = 100_000_000  # 10 Hz
Thought = tuple[Decision | None, Predictions | None]  # among people: what was decided, and among whom
NOTHING: Thought = (None, None)


def planned(state: StackState, place: Place, inputs: Inputs, setup: Setup) -> tuple[StackState, Thought]:
    """The state with its next plan, and what was thought of the people; `NOTHING` where it does not plan among them."""
    situation = Situation(
        now_ns=state.now_ns,
        road=setup.road,
        shape=setup.shape,
        station_m=place.at.station_m,
        speed_m_s=place.pose.speed_m_s,
        tracks=state.tracks.confirmed,
        slowing=state.slowing if state.driving else None,
        pose=(place.pose.x_m, place.pose.y_m, place.pose.heading_rad),
    )
    made = plan(situation, _before(state, place, setup), setup.settings.planning)
    state, thought = _among_people(state, situation, made, place, inputs, setup)
    waiting = wait_on(
        state.waiting,
        state.now_ns,
        driving=state.driving,
        stands=abs(place.pose.speed_m_s) < STANDS_M_S,
        for_person=made.blocked is not None and made.blocked.kind == "person",
        lost=state.topology.lost,
    )
    due = max(state.plan_due_ns, state.now_ns - PLAN_NS) + PLAN_NS
    return structs.replace(state, plan_due_ns=due, waiting=waiting), thought


def _before(state: StackState, place: Place, setup: Setup) -> Plan | None:
    """The last plan; among people the car drove elsewhere in its lane than the braking planner thought: from there it goes on."""
    if state.plan is None or state.way is None:
        return state.plan
    aside = place.at.offset_m - own_lane(setup.road).middle_m
    return replace(state.plan, shift=Shift(place.at.station_m, aside, aside))


def _among_people(
    state: StackState, situation: Situation, made: Plan, place: Place, inputs: Inputs, setup: Setup
) -> tuple[StackState, Thought]:
    """How people are passed; `made` says how fast at most. Not when somebody drives, or is to take over: nobody would use it.

    But a loss is looked at until it is over, also while it is what somebody is asked to take over for.
    """
    asked, is_open, passed_s = None, state.monitor.request is not None, _since_plan_s(state)
    if setup.among_people is not None and state.driving and (not is_open or state.waiting.is_lost):
        angle = inputs.wheels.road_wheel_angle_rad if inputs.wheels else 0.0
        taken = state.topology.taken
        before = taken.trajectory if taken is not None else None
        asked = around(made, situation, place.pose, angle, setup.among_people.lane, setup.settings.planning, before, passed_s)
    if asked is None:
        return structs.replace(state, plan=made, topology=TopologyState(), way=None), NOTHING
    topology, decision = plan_topology(state.topology, asked, setup.shape, setup.settings.topology, passed_s)
    if is_open:
        return structs.replace(state, plan=made, topology=topology, way=None), NOTHING
    thought = decision, asked.predictions
    if decision.braking:
        return structs.replace(state, plan=made, topology=topology), thought
    found = capped(decision.chosen.trajectory, made, setup.road, setup.settings.planning)
    made = replace(made, points=tuple((float(x), float(y)) for x, y in found.states[:, :2]))
    return structs.replace(
        state, plan=made, topology=topology, way=Way(found_ns=state.now_ns, reference=of_trajectory(found))
    ), thought


def _since_plan_s(state: StackState) -> float:
    return PLAN_PERIOD_S if state.plan is None else (state.now_ns - state.plan.stamp_ns) * 1e-9
