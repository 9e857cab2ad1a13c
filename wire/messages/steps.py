"""Steps of pure functions, recorded so that they can be run again: their time, inputs and outputs. See `wire.replay`.

What is Raw is the step's own structs as JSON; only the room that runs the step knows them.
"""

from typing import Annotated

import msgspec
from msgspec import Meta

from wire.messages.base import Count, Message, TimeNs


class MonitorStep(Message):
    """10 Hz. One look of the take-over monitor at its channels of doubt."""

    number: Count  # since the automation started
    now_ns: TimeNs  # vehicle clock
    settings: msgspec.Raw  # autonomy.uncertainty.monitor.MonitorSettings
    before: msgspec.Raw  # MonitorState before the step
    inputs: msgspec.Raw  # levels of the channels, and what a request would offer
    outputs: msgspec.Raw  # MonitorState after it


class TorqueSteps(Message):
    """10 Hz. The steps of the wheel's torque law of the last tenth of a second, 250 per second.

    Every batch carries what it starts from, so that a lost one costs its own steps and no more. Columns hold one value per
    step; one that never changed within the batch holds that value once.
    """

    stamp_ns: TimeNs  # tower clock: of the last step
    first: Count  # number of the first step, since the cockpit started
    count: Annotated[int, Meta(ge=1, le=1000)]  # ours: four seconds of steps; a batch is a tenth of one
    limits: msgspec.Raw  # haptics.alignment.WheelLimits
    before: msgspec.Raw  # WheelState before the first step
    inputs: msgspec.Raw  # columns: now_ns, dt_s and the fields of WheelInputs
    outputs: msgspec.Raw  # columns: the fields of WheelState
