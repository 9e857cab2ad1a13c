"""Questions the tower asks the car, and the answers: lease (who may ask), numbered hand-over, supervision, video session."""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from wire.messages.base import CAMERAS_MAX, Count, Message, Name, Text, TimeNs
from wire.messages.operating import Hmac

Pem = Annotated[str, Meta(max_length=4000)]  # ours: one of ours is 800 letters, with a few hosts
EcdsaSignature = Annotated[str, Meta(max_length=160)]  # hexadecimal DER; at most 72 bytes on P-256


class LeaseRequest(Message):
    """Ask for the exclusive right to ask. Also how a holder renews: same operator, same session."""

    operator: Name
    session: Name  # random per start of the cockpit: a returning tower is a new session and gets a new epoch
    sent_ns: TimeNs
    echoed_vehicle_ns: TimeNs = 0  # vehicle clock: newest GatewayStatus known when it was asked; an old question is refused
    echoed_boot_id: Name = ""
    certificate: Pem = ""  # the cockpit's own
    signature: EcdsaSignature = ""  # of all fields above under its key: wire.identity


class LeaseReply(Message):
    granted: bool
    epoch: Count  # strictly increasing over the life of the car; 0 when refused
    key_hex: Annotated[str, Meta(max_length=64)]  # HMAC-SHA256 key for commands and hand-over queries of this lease
    rule: Text  # why refused, "" when granted
    boot_id: Name


class Action(StrEnum):
    TAKE = "take"  # the operator wants to drive
    HAND_BACK = "hand_back"  # the operator wants the automation to drive again
    RETURN = "return"  # one press within the guard time: the operator drives again
    ENGAGE = "engage"  # from STANDBY: the automation starts to drive
    CLEAR = "clear"  # a remote STOP whose cause is gone is cleared; the car stays STOPPED
    PASS_ON = "pass_on"  # the operator who drives agrees: the next one, whom a supervisor named, may take over from him


class Outcome(StrEnum):
    GRANTED = "granted"
    REFUSED = "refused"


class HandOverRequest(Message):
    lease_epoch: Count
    number: Count  # the tower's own count: an answer belongs to its question
    action: Action
    sent_ns: TimeNs
    echoed_vehicle_ns: TimeNs = 0  # vehicle clock: newest GatewayStatus known when it was asked; an old question is refused
    echoed_boot_id: Name = ""
    hmac: Hmac = ""


class HandOverReply(Message):
    """The car's answer. What becomes of a grant (committed, expired, aborted) is told by GatewayStatus.hand_over."""

    number: Count
    outcome: Outcome
    rule: Text  # the rule that refused, with what to do; "" when granted
    lease_epoch: Count  # a grant carries the new epoch: commands with the old one are dropped from now on
    hand_over: Count = 0  # the car's number of what was granted; 0 where nothing is left to commit, or from an older car


class Supervision(StrEnum):
    # the lease ends now, and its holder gets none for a while; while he drives, with the next one named and no stop: as soon as
    # both are ready, or not at all
    REVOKE = "revoke"
    ADMIT = "admit"  # he may have one again
    RELEASE = "release"  # after three stops in ten minutes: the car may be taken over again


class SupervisionRequest(Message):
    """Only a supervisor asks this: signed with the key of a supervisor's certificate."""

    action: Supervision
    lease_epoch: Count  # REVOKE: of the lease that the supervisor saw; another one's is not revoked by mistake
    operator: Name  # REVOKE: who may have it next, "" for anybody; ADMIT: who is let in again
    reason: Annotated[str, Meta(max_length=200)]  # in words for the operator
    stop: bool  # REVOKE: also when an operator drives, which is a safe stop
    sent_ns: TimeNs
    echoed_vehicle_ns: TimeNs  # vehicle clock: newest GatewayStatus known; strictly increasing, an old one is refused
    echoed_boot_id: Name
    certificate: Pem = ""
    signature: EcdsaSignature = ""


class SupervisionReply(Message):
    done: bool
    rule: Text  # what refused it, with what to do; "" when done


class VideoOffer(Message):
    """SDP offer by the window, who receives. Cameras in the order of the video sections."""

    sdp: Annotated[str, Meta(max_length=65536)]
    cameras: Annotated[tuple[Name, ...], Meta(max_length=CAMERAS_MAX)]
    operator: Name = ""  # who sits before it: whoever drives gets the pictures that his own path carries
    watcher: Name = ""  # random per start of the window: its next offer replaces its own connection, and nobody else's


class VideoAnswer(Message):
    sdp: Annotated[str, Meta(max_length=65536)]
    cameras: Annotated[tuple[Name, ...], Meta(max_length=CAMERAS_MAX)]
    rule: Text  # why refused, "" when answered
