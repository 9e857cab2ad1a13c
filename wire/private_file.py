"""Whether a file with a secret is its owner's alone: a key that others can read, or could have replaced, proves nothing.

The rule of OpenSSH for private keys (`sshkey_perm_ok`), and root's files besides: root reads everything anyway.
Never changes a file: what was open to others may have been copied, and whoever set it up decides what it is still worth.
"""

import os
import stat
from pathlib import Path

_OTHERS = 0o077


def exposed(file: Path, mode: int, owner: int, reader: int) -> str:
    """Why nobody may rely on this file, with the fix; "" when only its owner can read and change it.

    mode    permission bits
    owner   user id of the file
    reader  user id of this process
    """
    if owner not in (reader, 0):
        return f"{file}: belongs to another user (id {owner}), who can change it; run as that user, or: chown {reader} {file}"
    if mode & _OTHERS:
        return (
            f"{file}: others may read or change it (mode {mode:03o}); run: chmod 600 {file} - where that has no effect, as on a "
            "memory stick, copy it into a folder of yours first"
        )
    return ""


def refusal(file: Path) -> str:
    """`exposed` of a file that is there. Raises OSError when it is not."""
    found = file.stat()
    return exposed(file, stat.S_IMODE(found.st_mode), found.st_uid, os.geteuid())
