"""Stories of one gateway that nobody thought of, made up by hypothesis; `must_hold` checks every cycle."""

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import Drive, M, Operator, autonomous, remote
from vehicle_gateway.gateway import recalled_state, remember
from wire.messages.base import Gear
from wire.messages.session import Action

SWITCHES = ("feedback", "cameras", "automation", "scenes")
HABITS = ("silent", "deaf", "frozen")


class AnyStory(RuleBasedStateMachine):
    """Arbitrary losses, presses, commands and pauses, from a car that drives itself or stands; `must_hold` checks each cycle."""

    @initialize(story=st.sampled_from([autonomous, remote, lambda: Drive().run(0.2), lambda: Drive(speed=4.0).run(0.02)]))
    def begin(self, story):
        self.drive = story()
        self.bob = Operator("bob", "s2")
        self.drive.operators.append(self.bob)

    @rule(seconds=st.sampled_from([0.01, 0.05, 0.15, 0.6, 2.0]))
    def time_goes_on(self, seconds):
        self.drive.run(seconds)

    @rule(dt_ms=st.sampled_from([1.0, 4.0, 50.0, 400.0, 3000.0]))
    def a_cycle_comes_early_or_late(self, dt_ms):
        self.drive.tick(dt_ms)

    @rule(name=st.sampled_from(SWITCHES), seconds=st.sampled_from([0.05, 0.3, 1.0]))
    def something_fails_for_a_while(self, name, seconds):
        setattr(self.drive, name, False)
        self.drive.run(seconds)
        setattr(self.drive, name, True)

    @rule(name=st.sampled_from(HABITS), seconds=st.sampled_from([0.05, 0.15, 0.3, 1.0, 6.0]))
    def the_operator_is_gone_for_a_while(self, name, seconds):
        setattr(self.drive.driver, name, True)
        self.drive.run(seconds)
        setattr(self.drive.driver, name, False)

    @rule(on=st.booleans())
    def commands_come_in_while_a_grant_is_made(self, on):
        self.drive.late_guard = on

    @rule(
        steer=st.sampled_from([None, -0.6, -0.02, 0.1]),
        throttle=st.sampled_from([-10.0, -2.0, 0.0, 0.5, 5.0]),
        gear=st.sampled_from(Gear),
        loop_ms=st.sampled_from([0, 80, 300, 600]),
        dead_man=st.booleans(),
    )
    def the_operator_acts(self, steer, throttle, gear, loop_ms, dead_man):
        driver = self.drive.driver
        driver.steer, driver.throttle, driver.gear, driver.loop_ms, driver.dead_man = steer, throttle, gear, loop_ms, dead_man
        self.drive.run(0.2)

    @rule(deaf=st.booleans())
    def the_operator_calmly_takes_over(self, deaf):
        driver = self.drive.driver
        driver.steer, driver.throttle, driver.gear, driver.loop_ms, driver.dead_man = None, 0.0, Gear.DRIVE, 80, True
        self.drive.run(0.3)
        driver.deaf = deaf
        self.drive.ask(Action.TAKE, driver)
        self.drive.run(0.05)
        driver.deaf = False

    @rule(steer=st.sampled_from([0.0, 0.2, -0.8]), acceleration=st.floats(-10.0, 5.0))
    def the_automation_acts(self, steer, acceleration):
        self.drive.auto_steer, self.drive.auto_acceleration = steer, acceleration

    @rule(changes=st.sampled_from([{}, {"healthy": False}, {"clear_s": 0.0}, {"state_matched": False}]))
    def the_automation_judges_itself(self, changes):
        self.drive.status = autonomy_status(**changes)

    @rule(budget_s=st.sampled_from([0.0, 1.0, 10.0]))
    def the_automation_asks(self, budget_s):
        self.drive.request_takeover(budget_s)

    @rule(action=st.sampled_from(Action), second=st.booleans())
    def a_question_comes(self, action, second):
        self.drive.ask(action, self.bob if second else self.drive.driver)

    @rule(second=st.booleans())
    def a_lease_is_asked_for(self, second):
        self.drive.lease(self.bob if second else self.drive.ann)

    @rule(number=st.integers(1, 3))
    def stop_is_pressed(self, number):
        self.drive.press_stop(number)

    @rule(
        local=st.sampled_from(
            [
                {"driver_torque_nm": 5.0},
                {"driver_brake": 0.3},
                {"emergency_button": True},
                {"release_button": True},
                {"seat_occupied": True},
                {"seat_occupied": True, "driver_torque_nm": -5.0},
                {"ecu_following": False},
            ]
        ),
        seconds=st.sampled_from([0.02, 0.07, 0.6]),
    )
    def the_person_in_the_car_acts(self, local, seconds):
        before = dict(self.drive.local)
        self.drive.local |= local
        self.drive.run(seconds)
        self.drive.local = before

    @rule(action=st.sampled_from(Action))
    def a_question_comes_in_the_cycle_of_an_emergency(self, action):
        self.drive.local["emergency_button"] = True
        self.drive.ask(action, self.drive.driver)
        del self.drive.local["emergency_button"]

    @rule()
    def the_gateway_dies_and_comes_back(self):
        drive = self.drive
        moving = abs(drive.speed) > 0.06
        epoch = drive.state.lease.epoch
        drive.state = recalled_state(remember(drive.state, epoch + 1_000_000, 0), "boot", drive.now, 0)
        drive.allowed_ns = 0
        assert drive.state.lease.epoch > epoch
        if drive.feedback:
            drive.tick()
            assert not moving or drive.mode in (M.SAFE_STOP, M.EMERGENCY_STOP, M.LOCAL_DRIVER), "it moves, and nobody stops it"

    def teardown(self):
        """In the end everybody who could drive is lost: the car stands, and soon."""
        if not hasattr(self, "drive"):
            return
        drive = self.drive
        drive.feedback, drive.automation = True, False
        drive.ann.silent = self.bob.silent = True
        drive.local = {"gear": Gear.DRIVE}
        drive.run(1.0 + abs(drive.speed) / 1.5 + 2.0)
        assert abs(drive.speed) < 0.06, f"still at {drive.speed} m/s in {drive.mode}"
        assert drive.mode in (M.STANDBY, M.STOPPED, M.SAFE_STOP, M.EMERGENCY_STOP, M.LOCAL_DRIVER)


AnyStory.TestCase.settings = settings(
    max_examples=60,
    stateful_step_count=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
test_no_story_breaks_what_must_hold = AnyStory.TestCase
