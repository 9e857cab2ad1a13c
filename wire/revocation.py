"""Certificates that are worth nothing any more, as one list signed by the authority. Pure; no file is touched here.

A certificate is revoked by its name: the name's generation rises, and the next certificate of that name is issued as NAME~1,
NAME~2. Access control at the hubs goes by names, so the old one is nobody's there; no serial number has to be looked up, and
who issues needs to remember nothing of what he issued before.
"""

import msgspec
from cryptography import x509

from wire.authority import SIGNATURE, Pair, is_signed_by
from wire.messages.base import UNDECODABLE, Count, Message, Name, decoder, encode


class Revocations(Message):
    """The file revoked.json beside the certificates, and a part of every bundle."""

    number: Count = 0  # rises with every revocation: of two lists the one with the higher is newer
    generations: dict[Name, Count] = {}  # by name without generation: the one that is good
    signature: str = ""  # of the rest, by the authority's key, in hexadecimal; "" when nothing was ever revoked

    def current(self, name: str) -> str:
        """The common name under which this name is good now."""
        generation = self.generations.get(name, 0)
        return f"{name}~{generation}" if generation else name

    def is_revoked(self, common_name: str) -> bool:
        name, generation = parted(common_name)
        return generation < self.generations.get(name, 0)


NOTHING = Revocations()


def parted(common_name: str) -> tuple[str, int]:
    """(name, generation) of a certificate's common name."""
    name, mark, generation = common_name.partition("~")
    return (name, int(generation)) if mark and generation.isdecimal() else (common_name, 0)


def with_revoked(known: Revocations, name: str, authority: Pair) -> Revocations:
    """The list with everything revoked that was ever issued under this name (without its generation)."""
    generations = known.generations | {name: known.generations.get(name, 0) + 1}
    bare = Revocations(number=known.number + 1, generations=generations)
    return msgspec.structs.replace(bare, signature=authority.key.sign(_signed_part(bare), SIGNATURE).hex())


def read_revocations(data: bytes, authority: x509.Certificate) -> Revocations:
    """The list in a file. Raises ValueError unless this authority has signed it."""
    try:
        known = decoder(Revocations).decode(data)
    except UNDECODABLE:
        raise ValueError("damaged, or no list of revoked certificates") from None
    check_revocations(known, authority)
    return known


def check_revocations(known: Revocations, authority: x509.Certificate) -> None:
    """Raises ValueError unless this authority has signed the list; an empty one needs no signature."""
    if known == NOTHING:
        return
    if not is_signed_by(authority, known.signature, _signed_part(known)):
        raise ValueError("the list of revoked certificates was not signed by the authority beside it")


def _signed_part(known: Revocations) -> bytes:
    return b"Revocations" + encode(msgspec.structs.replace(known, signature=""))
