"""Who watches a world and knows by plainer rules what may never happen. Every rule has a name; none asks the gateway.

The witness keeps accounts of its own: who holds the lease (by the answers that left the car), which commands had the right to
be obeyed (by who sent them, and when they arrived), how long somebody has been holding the wheel in the car.
"""

from collections import Counter
from math import atan, cos, isfinite, tan

from tests.safety.world import CAR, FOREVER_NS, LIMITS
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.automation import ZoneKind
from wire.messages.base import Gear
from wire.messages.session import Action, LeaseReply, Outcome, Supervision
from wire.messages.vehicle import Mode
from wire.road import wrap_angle

M = Mode
MS = 1_000_000
TINY = 1e-9
OPERATOR = (M.REMOTE, M.HANDING_BACK)
AUTOMATION = (M.AUTONOMOUS, M.TAKEOVER_REQUESTED)
BRAKING_MAX_M_S2 = 8.0
NEVER = -(10**18)
WALKING_M_S = 5 / 3.6


def watched(world, limits=LIMITS, car=CAR):
    """The world, with a witness from its first cycle on."""
    world.witness = Witness(world, limits, car)
    return world


class Right:
    """What one operator may be obeyed for: the lease that he was given, and what he has sent with it."""

    def __init__(self, owner=None, epoch=0):
        self.owner, self.epoch, self.sequence = owner, epoch, 0
        self.good = self.taken = None  # newest command that had the right to be obeyed; the one this cycle may know
        self.good_ns = self.right_ns = NEVER  # when it came; when the last one with the dead-man held came
        self.shown_ns, self.came_ns, self.told_ns, self.blind_ns = NEVER, NEVER, NEVER, 0  # told: by his own clock

    def saw_arrival(self, world, tower, command, at_ns):
        age_ms = (at_ns - command.echoed_vehicle_ns) / 1e6
        rightful = (
            tower.name == self.owner
            and command.hmac not in tower.forged
            and command.lease_epoch == self.epoch
            and command.echoed_boot_id == world.boot_id
            and 0.0 <= age_ms <= 500.0
            and command.sequence > self.sequence
        )
        if not rightful:
            return
        self.good, self.good_ns, self.sequence = command, at_ns, command.sequence
        self.right_ns = at_ns if command.dead_man else self.right_ns
        shown_ns = command.displayed_capture_ns.get("front", NEVER)
        if self.shown_ns < shown_ns <= at_ns:
            self.shown_ns, self.came_ns, self.told_ns = shown_ns, at_ns, command.sent_ns  # only a newer picture is a new one

    def saw_take(self):
        self.taken = self.good
        if self.good is not None:
            self.blind_ns = max(self.good.sent_ns - self.told_ns, self.good_ns - self.came_ns - 500 * MS)

    def ends(self):
        """What the cycle has taken of it already stays taken."""
        self.owner, self.epoch, self.right_ns = None, 0, NEVER


class Witness:
    def __init__(self, world, limits, car):
        self.limits, self.car = limits, car
        self.epochs = [0]
        self.stop_pressed = world.disk.stop_pressed
        self.track = []  # (now, angle) of the last second
        self.front_m = car.length_m - car.rear_overhang_m
        self.outside, self.ahead = False, world.pose[0]  # in the cycle before: whether the front was, and where
        self.changes = 0  # of the operator while the car was driven
        self.met = Counter()  # cycles in which a zone had something to say
        self.saw_start()

    def saw_start(self):
        """The gateway starts anew: nobody holds anything any more, and what was heard before counts for nothing."""
        self.held, self.next = Right(), Right()  # the lease, and the next operator's beside it
        self.named, self.named_ns = None, NEVER  # whom a supervisor lets take over from the driver, and since when
        self.automation_ns = self.fit_ns = NEVER
        self.held_since_ns = None  # since when somebody in the seat steers or brakes
        self.stop_from = None  # where a safe stop began: (travelled, speed)
        self.previous, self.first = (0.0, 0.0), True
        self.ends_ns = FOREVER_NS  # when the certificate ends that the lease was granted to
        self.sure_since_ns = None  # since when the gateway could know where it is, without a gap

    # accounts -------------------------------------------------------------------------------------------------------------

    def saw_arrival(self, world, tower, command, at_ns):
        for right in (self.held, self.next):
            right.saw_arrival(world, tower, command, at_ns)

    def saw_take(self):
        self.held.saw_take()
        self.next.saw_take()

    @property
    def owner(self):
        return self.held.owner

    def _account(self, world):
        inputs, now_ns = world.inputs, world.now_ns
        if inputs.autonomy is not None:
            self.automation_ns = now_ns
        if inputs.autonomy_status is not None:
            self.fit_ns = now_ns if inputs.autonomy_status.healthy else NEVER
        feedback = inputs.feedback
        if feedback is not None:
            held = feedback.seat_occupied and (abs(feedback.driver_torque_nm) > 3.0 or feedback.driver_brake > 0.1)
            self.held_since_ns = (now_ns if self.held_since_ns is None else self.held_since_ns) if held else None
        self.stop_pressed = self.stop_pressed or bool(inputs.stop_number)
        for tower, _, answer in world.answers:  # who shows a new certificate in the very cycle in which the old one ends goes on
            if isinstance(answer, LeaseReply) and answer.granted and (tower.name, answer.epoch) == (self.owner, self.held.epoch):
                self.ends_ns = world.recognised.ends_ns.get(tower.name, FOREVER_NS)
        waited_s = (now_ns - self.named_ns) / 1e9
        if world.before.authority.mode is not M.REMOTE or waited_s >= 60.0 or self.named in world.recognised.revoked:
            self.named = None
            self.next.ends()
        for order, reply in zip(world.inputs.supervision_requests, world.out.supervision_replies, strict=True):
            if order.action is Supervision.REVOKE and reply.done:
                self._account_order(world, order)
        if self.owner in world.recognised.revoked or now_ns >= self.ends_ns - 10_000 * MS:
            self.held.ends()

    def _account_order(self, world, order):
        """The lease is taken from its holder; or he drives, and another one may take over from him."""
        changes = world.before.authority.mode is M.REMOTE and order.operator and not order.stop
        self.named, self.named_ns = (order.operator, world.now_ns) if changes else (None, NEVER)
        self.next.ends()
        if not changes:
            self.held.ends()

    def _account_change(self, world):
        """The next operator was granted the car, and nothing stronger came: his commands count from this cycle on."""
        for tower, action, answer in world.answers:
            took = action is Action.TAKE and answer.outcome is Outcome.GRANTED and world.out.mode is M.REMOTE
            if took and self.next.owner == tower.name and answer.lease_epoch == self.next.epoch:
                self.held, self.next, self.named = self.next, Right(), None
                self.ends_ns = world.recognised.ends_ns.get(tower.name, FOREVER_NS)
                self.changes += 1

    def _account_answers(self, world):
        """After the cycle: who holds what from now on."""
        for tower, action, answer in world.answers:
            granted = answer.granted if isinstance(answer, LeaseReply) else answer.outcome is Outcome.GRANTED
            if not granted:
                continue
            epoch = answer.epoch if isinstance(answer, LeaseReply) else answer.lease_epoch
            known = epoch in self.epochs and not isinstance(answer, LeaseReply)  # of a lease that has just gone to another one
            if epoch not in (self.held.epoch, self.next.epoch) and not known:
                self._account_epoch(tower, epoch, isinstance(answer, LeaseReply))
            if isinstance(answer, LeaseReply) and epoch == self.held.epoch:
                self.ends_ns = world.recognised.ends_ns.get(tower.name, FOREVER_NS)
            if action is Action.CLEAR:
                self.stop_pressed = False

    def _account_epoch(self, tower, epoch, new_lease):
        assert epoch > max(self.epochs), "an epoch was given twice"
        self.epochs.append(epoch)
        if new_lease and tower.name == self.named:
            self.next = Right(tower.name, epoch)
        elif new_lease:
            self.held = Right(tower.name, epoch)
        else:
            self.held.epoch, self.held.right_ns = epoch, NEVER  # the new right begins with the first command that carries it

    # rules ----------------------------------------------------------------------------------------------------------------

    def saw_cycle(self, world, dt_ms):
        self._account(world)
        applied = world.out.applied
        if self.first and world.inputs.feedback is not None:
            self.previous, self.first = (world.inputs.feedback.road_wheel_angle_rad, self.previous[1]), False
        dt_s = min(dt_ms / 1e3, self.limits.gate.frame_longest_s)
        self.every_number_is_one(world)
        self.only_a_rightful_command_gets_in(world)
        self._account_change(world)
        self.nobody_is_driven_without_epoch_freshness_and_dead_man(world, applied)
        self.nobody_steers_without_them(world, applied)
        self.nobody_stays_at_the_wheel_who_is_gone(world)
        self.the_operator_sees_what_he_drives_into(world)
        self.limits_hold_in_every_frame(world, applied, dt_s)
        self.limits_hold_in_real_time(world, applied)
        self.braking_is_never_limited(world, applied)
        self.the_person_in_the_car_wins(world)
        self.the_button_in_the_car_stops_at_once(world)
        self.stop_of_the_tower_holds_until_it_is_cleared(world)
        self.a_safe_stop_ends_only_at_standstill_or_with_a_person(world)
        self.a_stop_ends_inside_the_bound(world)
        if world.limits.map is not None:
            self._account_place(world, dt_ms)
            self.nobody_hurries_where_it_is_slow(world, applied)
            self.nobody_leaves_the_fence(world)
            self.nobody_enters_a_crossing_without_room_behind_it(world)
        self.previous = (applied.road_wheel_angle_rad, applied.acceleration_m_s2)
        self._account_answers(world)

    def every_number_is_one(self, world):
        applied, state = world.out.applied, world.state
        numbers = (
            applied.road_wheel_angle_rad,
            applied.acceleration_m_s2,
            world.out.cap_m_s,
            state.odometry.x_m,
            state.loop_age_ms,
        )
        assert all(map(isfinite, numbers))

    def only_a_rightful_command_gets_in(self, world):
        if world.inputs.command is not None:
            assert world.inputs.command == self.held.taken, "a command got in that had no right to"
        if world.inputs.next_command is not None:
            assert world.inputs.next_command == self.next.taken, "a command of the next operator got in that had no right to"

    def nobody_is_driven_without_epoch_freshness_and_dead_man(self, world, applied):
        mode, now_ns = world.out.mode, world.now_ns
        if applied.acceleration_m_s2 <= 0.0:
            return
        if mode in OPERATOR:
            assert self.held.taken is not None and self.held.taken.lease_epoch == self.held.epoch, (
                "driven with no command of this epoch"
            )
            assert self.held.taken.dead_man and now_ns - self.held.right_ns <= 120 * MS, "driven without dead-man, or too late"
            assert applied.acceleration_m_s2 <= self.held.taken.acceleration_m_s2 + TINY, "driven harder than anybody asked"
        else:
            drives_itself = mode in AUTOMATION or (mode is M.HANDING_OVER and world.state.authority.origin in AUTOMATION)
            assert drives_itself, f"driven in {mode}"
            assert now_ns - self.automation_ns <= 200 * MS, "driven by an automation that is silent"
            assert now_ns - self.fit_ns <= 500 * MS, "driven by an automation that is not healthy"

    def nobody_steers_without_them(self, world, applied):
        if world.out.mode not in OPERATOR:
            return
        entitled = self.held.taken is not None and self.held.taken.dead_man and world.now_ns - self.held.right_ns <= 120 * MS
        held, angle = self.previous[0], applied.road_wheel_angle_rad
        assert entitled or abs(angle - held) < TINY or abs(angle) < abs(held), "steered without the right to"

    def nobody_stays_at_the_wheel_who_is_gone(self, world):
        if world.out.mode in OPERATOR:
            assert world.now_ns - self.held.right_ns <= 500 * MS, "the operator is gone, and the car is still his"

    def the_operator_sees_what_he_drives_into(self, world):
        """As of his last command, which alone tells it; his silence has its own rule."""
        if world.out.mode in OPERATOR:
            assert self.held.blind_ns <= 200 * MS, "the operator drives blind"

    def limits_hold_in_every_frame(self, world, applied, dt_s):
        angle, acceleration = applied.road_wheel_angle_rad, applied.acceleration_m_s2
        held, before = self.previous
        assert abs(angle) <= max(self.car.road_wheel_angle_max_rad, abs(held)) + TINY
        speed = max(abs(world.speed_seen()), 1.0)
        assert abs(angle - held) <= self.limits.gate.road_wheel_rate_max_rad_s * dt_s + TINY, "the steering leapt"
        curved = abs(tan(angle) - tan(held)) / self.car.wheelbase_m * speed**2  # lateral acceleration that this frame adds
        assert curved <= self.limits.gate.lateral_jerk_max_m_s3 * dt_s + 1e-6, "the car was jerked sideways"
        sideways_max = atan(self.car.wheelbase_m * self.limits.gate.lateral_acceleration_max_m_s2 / speed**2)
        assert abs(angle) <= max(sideways_max, abs(held)) + TINY, "steered further into a curve than the speed allows"
        assert -BRAKING_MAX_M_S2 <= acceleration <= 2.0
        assert acceleration <= max(before, 0.0) + self.limits.gate.traction_jerk_max_m_s3 * dt_s + TINY, "traction leapt"

    def limits_hold_in_real_time(self, world, applied):
        """Whatever the cycles were like: over any stretch of the last second the wheels turned no faster than they may.

        Of what is sent: a gateway that has not heard the car since it began says nothing, its own numbers move nobody's wheels.
        """
        if not world.out.send:
            return
        now_ns = world.now_ns
        self.track = [(at, angle) for at, angle in self.track if now_ns - at <= 1000 * MS]
        rate = self.limits.gate.road_wheel_rate_max_rad_s
        for at_ns, angle in (*self.track[:1], *self.track[-12:]):
            moved = abs(applied.road_wheel_angle_rad - angle)
            assert moved <= rate * (now_ns - at_ns) / 1e9 + TINY, "the wheels turned faster than they may"
        self.track.append((now_ns, applied.road_wheel_angle_rad))

    def braking_is_never_limited(self, world, applied):
        """The brake that somebody with the right to it asks for is applied in the very cycle, whoever drives."""
        command = world.inputs.command
        if command is not None and command.lease_epoch == self.held.epoch and world.now_ns - self.held.good_ns < 100 * MS:
            asked, pressed = command.acceleration_m_s2, command.acceleration_m_s2 <= -1.0
            assert not pressed or applied.acceleration_m_s2 <= max(asked, -BRAKING_MAX_M_S2) + TINY, (
                "the operator's brake was weakened"
            )
        automation = world.inputs.autonomy
        if automation is not None and world.out.mode in AUTOMATION:
            asked = automation.acceleration_m_s2
            assert asked >= 0.0 or applied.acceleration_m_s2 <= max(asked, -BRAKING_MAX_M_S2) + TINY

    def the_person_in_the_car_wins(self, world):
        if self.held_since_ns is None or world.inputs.feedback is None:
            return
        long_enough = world.now_ns - self.held_since_ns >= 50 * MS
        assert not long_enough or world.out.mode in (M.LOCAL_DRIVER, M.EMERGENCY_STOP), "somebody in the seat is not let drive"

    def the_button_in_the_car_stops_at_once(self, world):
        feedback = world.inputs.feedback
        if feedback is not None and feedback.emergency_button:
            assert world.out.mode is M.EMERGENCY_STOP
        left = world.before.authority.mode is M.EMERGENCY_STOP and world.out.mode is not M.EMERGENCY_STOP
        assert not left or (feedback is not None and feedback.release_button) or world.state.feedback.release_button

    def stop_of_the_tower_holds_until_it_is_cleared(self, world):
        if self.stop_pressed and world.before.authority.mode is not M.LOCAL_DRIVER:
            cleared = any(action is Action.CLEAR for _, action, _ in world.answers)
            assert cleared or world.out.mode not in (*OPERATOR, *AUTOMATION, M.HANDING_OVER), "it drives though STOP was pressed"

    def a_safe_stop_ends_only_at_standstill_or_with_a_person(self, world):
        before, after = world.before.authority.mode, world.out.mode
        if before is M.SAFE_STOP and after not in (M.SAFE_STOP, M.LOCAL_DRIVER, M.EMERGENCY_STOP):
            assert abs(world.speed_seen()) < 0.05, f"a safe stop ended in {after} at {world.speed_seen()} m/s"

    def a_stop_ends_inside_the_bound(self, world):
        """By the printed formula: reaction of one cycle, braking of 2.5 m/s2 built up with 5 m/s3."""
        if world.out.mode is not M.SAFE_STOP:
            self.stop_from = None
            return
        if self.stop_from is None:
            self.stop_from = (world.travelled_m, abs(world.speed))
        began_m, speed = self.stop_from
        bound_m = stopping_distance_m(speed, 0.1, self.limits.safe_stop.braking_m_s2, self.limits.safe_stop.jerk_m_s3)
        assert world.travelled_m - began_m <= bound_m + 0.05, "the safe stop was longer than its bound"

    # zones: stations are x and offsets are y, the car's true ones ----------------------------------------------------------

    def _account_place(self, world, dt_ms):
        """Since when it was told ten times a second where the car is, in a straight line of cycles, and moved it itself."""
        _, y, heading = world.pose
        told = not (world.automation_dead or world.feedback_lost) and dt_ms <= 100.0 and world.inputs.feedback is not None
        along = abs(wrap_angle(heading)) < 0.5 and abs(y) < 30.0 and world.speed >= 0.0
        if not (told and along and world.out.mode is not M.LOCAL_DRIVER):
            self.sure_since_ns = None
        elif self.sure_since_ns is None:
            self.sure_since_ns = world.now_ns

    def _surely(self, world):
        """For so long that whatever it did before has been braked away."""
        return self.sure_since_ns is not None and world.now_ns - self.sure_since_ns > 5000 * MS

    def nobody_hurries_where_it_is_slow(self, world, applied):
        """Five metres inside a speed zone, or outside the fence, wherever the gateway believes to be: who is too fast brakes."""
        x, y, _ = world.pose
        for zone in world.limits.map.zones:
            inside = min(x - zone.from_station_m, zone.to_station_m - x, y - zone.right_m, zone.left_m - y)
            slow = inside > 5.0 if zone.kind is ZoneKind.SPEED else zone.kind is ZoneKind.ALLOWED and inside < -5.0
            most = (zone.speed_m_s or WALKING_M_S) if slow else None
            if most is None or world.out.mode is M.LOCAL_DRIVER:
                continue
            speed_m_s = abs(world.speed_seen())
            self.met["slow"] += speed_m_s > 0.95 * most
            assert speed_m_s <= most + 0.01 or applied.acceleration_m_s2 < 0.0, f"{speed_m_s} m/s at {x} m, {y} m"

    def nobody_leaves_the_fence(self, world):
        front = world.pose[0] + self.front_m * cos(world.pose[2])
        (fence,) = (zone for zone in world.limits.map.zones if zone.kind is ZoneKind.ALLOWED)
        if self._surely(world):
            self.met["fence"] += fence.to_station_m - front < 1.0
            assert front < fence.to_station_m or self.outside, "it left the geofence"
        self.outside = front >= fence.to_station_m

    def nobody_enters_a_crossing_without_room_behind_it(self, world):
        front = world.pose[0] + self.front_m * cos(world.pose[2])
        (crossing,) = (zone for zone in world.limits.map.zones if zone.kind is ZoneKind.NO_STOP)
        if self._surely(world) and world.objects:
            self.met["crossing"] += -1.0 < front - crossing.from_station_m < 0.0
            assert not self.ahead < crossing.from_station_m <= front, "it entered a crossing that it cannot leave"
        self.ahead = front

    def everybody_is_lost(self, world):
        """Nobody who could drive is left: the car stands, inside the bound for the slowest of all reactions."""
        world.automation_dead, world.feedback_lost, world.local = True, False, {}
        for tower in world.towers:
            tower.silent = True
        world.tick()
        if world.out.mode is M.LOCAL_DRIVER:
            return
        began_m, speed = world.travelled_m, abs(world.speed) + 2.0 * 0.2  # full traction for 200 ms before it is missed
        lost_s = self.limits.failsafe.command_lost_ms / 1e3 + 0.02 + world.delay_ms / 1e3
        bound_m = stopping_distance_m(speed, lost_s, 2.0, self.limits.safe_stop.jerk_m_s3) + 0.1
        for _ in range(round(100 * (2.5 + speed / 2.0))):
            world.tick()
            if abs(world.speed) < 0.05 and world.out.mode not in (*OPERATOR, *AUTOMATION):
                break
        assert abs(world.speed) < 0.05, f"still at {world.speed} m/s in {world.out.mode}"
        assert world.travelled_m - began_m <= bound_m, f"{world.travelled_m - began_m:.1f} m, the bound is {bound_m:.1f} m"
        assert world.out.applied.gear is not Gear.REVERSE or world.out.applied.acceleration_m_s2 <= 0.0
