"""The car's audit trail: one record per grant, refusal, intervention, failsafe, change of mode, drive, start and end.

`AuditEntry` is what happened; `AuditRecord` is that entry as it was written, with the hash of its bytes. How records are chained
and signed stands in `wire.audit_chain`. Content: StVFernLV Annex 3 (vehicle, position, numbered begin and end of every remote
drive, the operator's certificate, monitoring and fault entries, software version).
"""

from enum import StrEnum, auto
from typing import Annotated

import msgspec
from msgspec import Meta

from wire.messages.base import Angle, Count, Length, Message, Name, Position, Seconds, Speed, Text, TimeNs
from wire.messages.vehicle import Actuation, Mode

Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Fingerprint = Annotated[str, Meta(pattern="^([0-9a-f]{64})?$")]  # SHA-256 of a certificate's DER; "" where it is not known


class AuditKind(StrEnum):
    START = auto()  # of the gateway: software, configuration
    DRIVE_BEGIN = auto()  # a remote drive, numbered
    DRIVE_END = auto()
    MODE = auto()  # who drives has changed, and why
    LEASE = auto()  # granted to an operator
    LEASE_LOST = auto()
    ORDER = auto()  # a supervisor: lease revoked, operator admitted, car released
    GRANT = auto()  # a question of the operator: take, hand back, return, engage, clear
    REFUSAL = auto()  # of a lease or such a question, with the rule
    REFUSAL_END = auto()  # how often the same was asked and refused
    HAND_OVER = auto()  # what became of a grant: committed, expired, aborted
    REQUEST = auto()  # the automation asks for an operator
    STOP = auto()  # pressed in the tower
    INTERVENTION = auto()  # the gate begins to change what is asked for
    INTERVENTION_END = auto()
    FAILSAFE = auto()  # a cause is there
    FAILSAFE_END = auto()
    DROPPED = auto()  # messages that the gateway refused or lost since it last said so, by reason
    LOST = auto()  # entries that could not be kept, and how many
    HEAD = auto()  # signed: everything up to here is as it was written
    END = auto()  # the gateway ended in order


class MapPosition(Message):
    """Where the car was by its automation's scene; degrees only where the map's origin is configured."""

    x_m: Position  # map frame: x east, y north
    y_m: Position
    heading_rad: Angle
    deviation_m: Length
    age_s: Seconds  # of this pose when the entry was made
    latitude_deg: Annotated[float, Meta(ge=-90.0, le=90.0)] | None = None  # WGS 84, five decimals
    longitude_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] | None = None
    altitude_m: Annotated[float, Meta(ge=-500.0, le=9000.0)] | None = None  # of the map's origin: the map is flat


class AuditEntry(Message):
    """What happened. Fields that a kind has no use for keep their defaults."""

    number: Annotated[int, Meta(ge=1, le=2**53)]  # of the car's whole life, without a gap
    previous: Sha256  # hash of the record before; of the first: zeros
    kind: AuditKind
    stamp_ns: TimeNs  # vehicle clock
    utc_ns: TimeNs  # Unix time by the car's own clock
    boot_id: Name
    vehicle_id: Name
    mode: Mode  # after it happened
    drive: Count  # number of the remote drive in progress, or of the last one; 0: none yet
    remote: bool  # an operator drives
    operator: Name = ""  # who holds the lease, or asked
    certificate: Fingerprint = ""  # of the operator's certificate
    subject: Name = ""  # the rule of the gate, the cause, the action asked for, the mode before
    text: Text = ""  # in words: why, which rule refused
    epoch: Count = 0  # of the lease
    question: Count = 0  # the tower's number of a question or a STOP, the car's number of a hand-over
    times: Count = 0  # of an end: cycles in which the rule acted, questions refused; of DROPPED: messages; of LOST: entries
    lasted_s: Seconds = 0.0  # of an end: from the first to the last time
    requested: Actuation | None = None  # of an intervention: when it began; of its end: when it changed most
    applied: Actuation | None = None
    speed_m_s: Speed = 0.0
    position: MapPosition | None = None
    software: Text = ""  # of START
    configuration_sha256: Fingerprint = ""  # of START: of the configuration's file
    signer_pem: Annotated[str, Meta(max_length=8000)] = ""  # of HEAD: the certificate whose key signed


class AuditRecord(Message):
    """One entry as it was written. The hash is of the bytes of `entry`, whatever a later version makes of them."""

    stamp_ns: TimeNs  # the entry's own
    entry: msgspec.Raw  # AuditEntry as JSON
    hash: Sha256
    signature: Annotated[str, Meta(pattern="^([0-9a-f]{2}){0,80}$")] = ""  # of HEAD: ECDSA P-256 with SHA-256 over `hash`, DER
