"""What the demo's supervisor sees at the car's hub: who drives, and the referee. It looks on; nothing depends on it."""

import re
from dataclasses import dataclass, field

from wire.messages.sensing import Referee
from wire.messages.vehicle import GatewayStatus, Mode

WORDS = {
    Mode.STANDBY: "the car stands by",
    Mode.AUTONOMOUS: "the car drives itself",
    Mode.TAKEOVER_REQUESTED: "the car asks for a take-over",
    Mode.HANDING_OVER: "control changes hands",
    Mode.REMOTE: "the operator drives",
    Mode.HANDING_BACK: "the operator hands back",
    Mode.LOCAL_DRIVER: "a person in the car drives",
    Mode.SAFE_STOP: "the car brings itself to a stop",
    Mode.STOPPED: "the car stands",
    Mode.EMERGENCY_STOP: "emergency stop",
}
ASKING = (Mode.TAKEOVER_REQUESTED, Mode.STOPPED)


@dataclass(slots=True)
class Story:
    """What has happened so far; `look` returns the lines that are new."""

    mode: Mode | None = None
    was_remote: bool = False
    goal_reached: bool = False
    collisions: int = 0
    elapsed_s: float = 0.0
    refused: str = ""
    started_s: float | None = None
    stopped_since_s: float | None = None
    _told: set[str] = field(default_factory=set)  # refusals, without their figures

    def look(self, status: GatewayStatus | None, referee: Referee | None) -> list[str]:
        lines = []
        if referee is not None:
            lines += self._of_referee(referee)
        if status is not None:
            lines += self._of_status(status)
        return lines

    def _of_referee(self, referee: Referee) -> list[str]:
        lines = []
        self.elapsed_s = referee.elapsed_s
        self.started_s = self.elapsed_s if self.started_s is None else self.started_s
        if referee.collisions > self.collisions:
            lines.append(f"COLLISION with a {referee.collided_with}")
        if referee.goal_reached and not self.goal_reached:
            lines.append("the goal is reached")
        self.collisions, self.goal_reached = referee.collisions, referee.goal_reached
        return lines

    def _of_status(self, status: GatewayStatus) -> list[str]:
        lines = []
        if status.mode is not self.mode:
            lines.append(f"{WORDS[status.mode]}: {status.cause}" if status.cause else WORDS[status.mode])
            self.stopped_since_s = self.elapsed_s if status.mode is Mode.STOPPED else None
        self.mode = status.mode
        self.was_remote = self.was_remote or status.mode is Mode.REMOTE
        refusal = re.sub(r"\d+", "#", status.take_refused)
        if refusal and status.mode in ASKING and refusal not in self._told:
            self._told.add(refusal)
            lines.append(f"a take-over would be refused: {status.take_refused}")
        self.refused = status.take_refused
        return lines
