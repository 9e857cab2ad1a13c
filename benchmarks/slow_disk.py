"""A folder whose disk can be slow: a file system in user space (FUSE) over another folder, each write as late as it is told.

Speaks the kernel's own protocol (linux/fuse.h, 7.31) through /dev/fuse: what a recorder needs, nothing more; every other request
is answered ENOSYS. One request after the other, as a disk does. Needs root. Use it from a process that reads the folder beneath,
never the mounted one.
"""

import ctypes
import os
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from errno import ENOENT, ENOSYS
from pathlib import Path

IN, OUT = struct.Struct("<IIQQIIIHH"), struct.Struct("<IiQ")
ATTR, ENTRY, OPENED = struct.Struct("<QQQQQQIIIIIIIIII"), struct.Struct("<QQQQII"), struct.Struct("<QII")
INIT_OUT = struct.Struct("<IIIIHHIIHHI28x")
READ_IN, WRITE_IN = struct.Struct("<QQIIQII"), struct.Struct("<QQIIQII")
ROOT, FATTR_SIZE, MAX_WRITE = 1, 1 << 3, 1 << 17
MNT_DETACH = 2
SILENT = frozenset({2, 36, 42})  # FORGET, INTERRUPT, BATCH_FORGET want no answer
REQUEST_MAX = MAX_WRITE + 4096


class Disk:
    """Answers requests until its device is closed. `delay_s` may be changed at any time."""

    def __init__(self, folder: Path, device: int) -> None:
        self.delay_s = 0.0
        self._folder, self._device = folder, device
        self._paths = {ROOT: folder}
        self._pause = threading.Event()
        self._answers: dict[int, Callable[[int, bytes], bytes]] = {
            1: lambda node, name: self._entry(self._below(node, name)),
            3: lambda node, _: self._attributes(self._paths[node]),
            4: self._set,
            9: self._make_folder,
            10: self._unlink,
            12: lambda node, body: self._rename(node, body, 8),
            14: lambda node, body: OPENED.pack(os.open(self._paths[node], _flags(body)), 0, 0),
            15: self._read,
            16: self._write,
            17: lambda _, __: struct.pack("<5Q4I24x", 1 << 30, 1 << 29, 1 << 29, 1 << 20, 1 << 20, 4096, 255, 4096, 0),
            18: self._close,
            20: self._sync,
            25: lambda _, __: b"",  # FLUSH
            26: lambda _, body: INIT_OUT.pack(7, 31, struct.unpack_from("<IIII", body)[2], 0, 16, 12, MAX_WRITE, 1, 32, 0, 0),
            27: lambda _, __: OPENED.pack(0, 0, 0),
            28: self._list,
            29: lambda _, __: b"",  # RELEASEDIR
            35: self._create,
            45: lambda node, body: self._rename(node, body, 16),
        }

    def run(self) -> None:
        with suppress(OSError):  # unmounted
            while True:
                self._answer(os.read(self._device, REQUEST_MAX))

    def _answer(self, request: bytes) -> None:
        _, kind, unique, node, *_ = IN.unpack_from(request)
        if kind in SILENT:
            return
        error, body = 0, b""
        try:
            body = self._answers[kind](node, request[IN.size :])
        except KeyError:
            error = -ENOSYS if kind not in self._answers else -ENOENT
        except OSError as failed:
            error = -(failed.errno or ENOENT)
        os.write(self._device, OUT.pack(OUT.size + len(body), error, unique) + body)

    def _below(self, node: int, name: bytes) -> Path:
        return self._paths[node] / os.fsdecode(name.split(b"\0", 1)[0])

    def _entry(self, path: Path) -> bytes:
        node = path.stat().st_ino if path != self._folder else ROOT
        self._paths[node] = path
        return ENTRY.pack(node, 0, 0, 0, 0, 0) + self._status(path)

    def _attributes(self, path: Path) -> bytes:
        return struct.pack("<QII", 0, 0, 0) + self._status(path)

    def _status(self, path: Path) -> bytes:
        told = path.stat()
        times = (int(told.st_atime), int(told.st_mtime), int(told.st_ctime), 0, 0, 0)
        node = ROOT if path == self._folder else told.st_ino
        owner = (told.st_mode, told.st_nlink, told.st_uid, told.st_gid, 0, 4096, 0)
        return ATTR.pack(node, told.st_size, told.st_blocks, *times, *owner)

    def _set(self, node: int, body: bytes) -> bytes:
        valid, _, _, size = struct.unpack_from("<IIQQ", body)
        if valid & FATTR_SIZE:
            os.truncate(self._paths[node], size)
        return self._attributes(self._paths[node])

    def _make_folder(self, node: int, body: bytes) -> bytes:
        path = self._below(node, body[8:])
        path.mkdir()
        return self._entry(path)

    def _unlink(self, node: int, name: bytes) -> bytes:
        self._below(node, name).unlink()
        return b""

    def _rename(self, node: int, body: bytes, names_at: int) -> bytes:
        (to,) = struct.unpack_from("<Q", body)
        old, new = body[names_at:].split(b"\0")[:2]
        there = self._below(to, new)
        self._below(node, old).replace(there)
        self._paths[there.stat().st_ino] = there
        return b""

    def _create(self, node: int, body: bytes) -> bytes:
        path = self._below(node, body[16:])
        handle = os.open(path, _flags(body) | os.O_CREAT, struct.unpack_from("<I", body, 4)[0] & 0o777)
        return self._entry(path) + OPENED.pack(handle, 0, 0)

    def _read(self, _: int, body: bytes) -> bytes:
        handle, offset, size, *_rest = READ_IN.unpack_from(body)
        return os.pread(handle, size, offset)

    def _write(self, _: int, body: bytes) -> bytes:
        self._pause.wait(self.delay_s)
        handle, offset, size, *_rest = WRITE_IN.unpack_from(body)
        return struct.pack("<II", os.pwrite(handle, body[WRITE_IN.size : WRITE_IN.size + size], offset), 0)

    def _sync(self, _: int, body: bytes) -> bytes:
        os.fsync(*struct.unpack_from("<Q", body))
        return b""

    def _close(self, _: int, body: bytes) -> bytes:
        os.close(*struct.unpack_from("<Q", body))
        return b""

    def _list(self, node: int, body: bytes) -> bytes:
        _, offset, size, *_rest = READ_IN.unpack_from(body)
        listed = b""
        for number, path in list(enumerate(sorted(self._paths[node].iterdir()), start=1))[offset:]:
            name = os.fsencode(path.name)
            one = struct.pack("<QQII", path.stat().st_ino, number, len(name), 0) + name
            one += b"\0" * (-len(one) % 8)
            if len(listed) + len(one) > size:
                break
            listed += one
        return listed


def _flags(body: bytes) -> int:
    """Of open(2); a file is never opened to append, the kernel says where."""
    return int(struct.unpack_from("<I", body)[0]) & ~(os.O_APPEND | os.O_EXCL | os.O_CREAT)


@contextmanager
def slow_disk(folder: Path, mounted: Path) -> Iterator[Disk]:
    """What is written below `mounted` lands in `folder`. Raises OSError where FUSE is missing or not permitted."""
    for each in (folder, mounted):
        each.mkdir(parents=True, exist_ok=True)
    libc = ctypes.CDLL(None, use_errno=True)
    device = os.open("/dev/fuse", os.O_RDWR)
    options = f"fd={device},rootmode=40755,user_id=0,group_id=0,allow_other".encode()
    if libc.mount(b"slow", os.fsencode(mounted), b"fuse", 0, options):
        os.close(device)
        raise OSError(ctypes.get_errno(), f"mount: {os.strerror(ctypes.get_errno())}")
    disk = Disk(folder, device)
    thread = threading.Thread(target=disk.run, name="slow disk", daemon=True)
    thread.start()
    try:
        yield disk
    finally:
        disk.delay_s = 0.0
        libc.umount2(os.fsencode(mounted), MNT_DETACH)
        os.close(device)
        thread.join(5.0)
