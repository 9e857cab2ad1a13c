"""Zenoh's configuration of one process: how a site's hub and its clients meet, which certificates they show, what may pass.

Facts and measurements behind the settings: ARCHITECTURE.md, "The link". Nothing is opened here.
"""

import json
import logging
from pathlib import Path
from typing import Any

import zenoh

from wire import certificates
from wire.access import access_control, admitted
from wire.endpoint import EVERYWHERE
from wire.failures import LinkError
from wire.revocation import Revocations
from wire.settings import LinkSettings
from wire.site import dialled, listened, own_hub, site_of, vehicles
from wire.topics import Role

log = logging.getLogger(__name__)

_OPEN_TIMEOUT_MS = 1000  # how long one attempt to reach the hub may take before SIGTERM is looked at again


def session_configuration(settings: LinkSettings, role: Role, hub: bool, waits: bool = True) -> zenoh.Config:
    """The Zenoh configuration of one process. Raises LinkError when certificates are missing from a folder that holds some.

    Where there are none at all the first program makes them: one command is enough to run on one machine.
    """
    folder = certificates.folder_of(settings.certificates)
    if certificates.make_if_none(folder):
        log.info("made a local authority and certificates in %s", folder)
    site = site_of(role)
    entries: dict[str, Any] = {
        "mode": "router" if hub else "client",
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/tx/lease": settings.lease_ms,
        "transport/link/tx/keep_alive": 4,
        "transport/link/tx/queue/size/data": 16,  # batches of 64 kB: pictures come in bursts, and a dropped one is lost
        "transport/link/tx/queue/size/interactive_high": 16,  # batches of a datagram: two are full with what a car says at once
        "transport/link/tls": tls_of(settings, role),
    }
    if hub:
        entries["listen/endpoints"] = [each.zenoh for each in listened(settings, site)] if waits else []
        names = admitted(settings, revoked(folder))
        entries["access_control"] = access_control(vehicles(settings, site), site, settings.accepts_script, names)
        entries["connect/endpoints"] = [each.zenoh for each in dialled(settings, site)]
        entries["connect/timeout_ms"] = -1  # in the background, for ever; 0 would be one attempt
        entries["connect/exit_on_failure"] = False
        entries["connect/retry"] = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5}
    else:
        entries["connect/endpoints"] = [own_hub(settings, site).zenoh]
        entries["connect/timeout_ms"] = _OPEN_TIMEOUT_MS
        entries["connect/retry"] = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}
    configuration = zenoh.Config()
    for name, value in entries.items():
        configuration.insert_json5(name, json.dumps(value))
    return configuration


def revoked(folder: Path) -> Revocations:
    """What the authority has revoked, as far as it was told here. Raises LinkError when the list is not the authority's."""
    try:
        return certificates.revocations_of(folder)
    except certificates.CertificateError as error:
        raise LinkError(str(error)) from None


def tls_of(settings: LinkSettings, role: Role) -> dict[str, Any]:
    """Zenoh's transport/link/tls of a role. Raises LinkError when its certificate is missing, damaged or has expired."""
    folder = certificates.folder_of(settings.certificates)
    try:
        certificates.check(folder, role, settings.vehicle_id)
    except certificates.CertificateError as error:
        raise LinkError(str(error)) from None
    key_file, certificate = str(folder / f"{role}.key"), str(folder / f"{role}.pem")
    return {
        "root_ca_certificate": str(folder / f"{certificates.AUTHORITY}.pem"),
        "enable_mtls": True,
        "listen_private_key": key_file,
        "listen_certificate": certificate,
        "connect_private_key": key_file,
        "connect_certificate": certificate,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,  # tried: without it an expired certificate goes on for as long as its session lasts
    }


def warn_of_unnamed(settings: LinkSettings, role: Role) -> None:
    """Tell of an address that we listen on and our certificate does not name."""
    hosts = tuple(place.host for place in listened(settings, site_of(role)) if place.host not in EVERYWHERE)
    for host in certificates.unnamed(certificates.folder_of(settings.certificates), role, hosts):
        log.warning("our certificate does not name %s: who dials it will refuse us; make or export it with --host %s", host, host)
