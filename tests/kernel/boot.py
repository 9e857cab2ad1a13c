"""Boots Debian's kernel in QEMU and runs the tests of this folder inside it: `make test-kernel`.

There the kernel has SocketCAN, uinput and netem, which containers and cloud machines lack. The guest sees this machine's files
read-only under a tmpfs: the same .venv runs inside, and nothing it does comes out. Always emulated (TCG), so that it is the same
with and without /dev/kvm. Kernel and initramfs lie in .kernel/, outside git. Exit code: pytest's; 2 when the guest cannot be had.
"""

import compileall
import gzip
import lzma
import os
import platform
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
CACHE = REPOSITORY / ".kernel"
LINUX = CACHE / "linux"
PATIENCE_S = 900.0  # for everything; on a machine that others use as well it takes five minutes and more
CANNOT = 2
TOOLS = {  # program: its package
    "qemu-system-x86_64": "qemu-system-x86",
    "busybox": "busybox-static",
    "depmod": "kmod",
    "ip": "iproute2",
    "tc": "iproute2",
}
SYSTEM = "/usr/local/sbin:/usr/sbin:/sbin"  # not in every user's PATH
IMAGES = ("linux-image-amd64", "linux-image-generic")  # Debian's (not its cloud kernel: no CAN, no 9p), Ubuntu's
BEFORE_ROOT = ("virtio_pci", "virtio_rng", "9pnet_virtio", "9p", "overlay")
COMMAND_LINE = (
    "console=ttyS0 quiet loglevel=3 panic=-1 mitigations=off audit=0 nowatchdog random.trust_cpu=on tsc=reliable "
    "norandmaps transparent_hugepage=never rcupdate.rcu_expedited=1 rdinit=/init tower.kernel-guest"
)


class Missing(Exception):
    """The guest cannot be had here; the text says what to install."""


def main(arguments: list[str]) -> int:
    os.environ["PATH"] += os.pathsep + SYSTEM
    try:
        ensure_tools()
        ensure_kernel()
    except Missing as missing:
        print(f"make test-kernel: {missing}", file=sys.stderr)
        return CANNOT
    compile_ours()
    return run_guest(write_initramfs(arguments))


def compile_ours() -> None:
    """Bytecode of our modules: the guest reads it, and what it compiles itself is gone with it."""
    for room in sorted({module.parent for module in REPOSITORY.glob("*/__init__.py")} | {HERE}):
        compileall.compile_dir(room, quiet=2)


def ensure_tools() -> None:
    """Programs of this machine; installed when we may. Raises Missing."""
    if platform.machine() != "x86_64":
        raise Missing(f"needs an x86-64 machine: the guest runs this machine's own programs, and this is {platform.machine()}")
    absent = sorted({package for program, package in TOOLS.items() if shutil.which(program) is None})
    if not absent:
        return
    fix = "programs are missing; install them: apt-get install --no-install-recommends " + " ".join(absent)
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        raise Missing(fix)
    print("installing", *absent, flush=True)
    if not (_apt("update") and _apt("install", "--yes", "--no-install-recommends", *absent)):
        raise Missing(fix)


def ensure_kernel() -> None:
    """.kernel/linux: the newest kernel the package archive has, unpacked, not installed. Raises Missing."""
    if (CACHE / "ready").is_file():
        return
    shutil.rmtree(CACHE, ignore_errors=True)
    CACHE.mkdir()
    packages = _kernel_packages()
    if not packages and os.geteuid() == 0 and _apt("update"):
        packages = _kernel_packages()
    if not packages or not _apt("download", *packages):
        raise Missing(f"no kernel to download; as root run: apt-get update   (it wants one of: {', '.join(IMAGES)})")
    for archive in CACHE.glob("*.deb"):
        subprocess.run(["dpkg-deb", "-x", archive, LINUX], check=True)
        archive.unlink()
    if not (LINUX / "lib").exists():
        (LINUX / "lib").symlink_to("usr/lib")
    subprocess.run(["depmod", "-b", LINUX, release()], check=True)
    (CACHE / "ready").write_text(release() + "\n")


def _apt(*arguments: str) -> bool:
    """Quiet; what went wrong is shown."""
    try:
        done = subprocess.run(
            ["apt-get", "-q", *arguments],
            cwd=CACHE if CACHE.is_dir() else None,
            env=os.environ | {"DEBIAN_FRONTEND": "noninteractive"},
            capture_output=True,
            text=True,
            check=False,
        )
    except FileNotFoundError:
        return False
    if done.returncode != 0:
        print(done.stderr.strip(), file=sys.stderr)
    return done.returncode == 0


def _kernel_packages() -> list[str]:
    """The packages behind the newest of IMAGES: Debian has all in one, Ubuntu modules apart."""
    for image in IMAGES:
        try:
            told = subprocess.run(["apt-cache", "depends", "--recurse", image], capture_output=True, text=True, check=False).stdout
        except FileNotFoundError:
            return []
        found = re.findall(r"^linux-(?:image|modules|modules-extra)-\d\S*$", told, re.MULTILINE)
        if found:
            return sorted(set(found))
    return []


def release() -> str:
    return next(LINUX.glob("boot/vmlinuz-*")).name.removeprefix("vmlinuz-")


def write_initramfs(arguments: list[str]) -> Path:
    """busybox, the modules that reach the host's files, and init.sh, in cpio's newc format; anew each time: 1.5 MB."""
    modules = LINUX / "lib/modules" / release()
    files = {
        "init": (HERE / "init.sh").read_bytes(),
        "bin/busybox": Path(shutil.which("busybox") or "").read_bytes(),
        "arguments": "\n".join([str(REPOSITORY), *arguments]).encode(),
    }
    for number, module in enumerate(in_order(modules)):
        raw = module.read_bytes()
        files[f"modules/{number:02d}-{module.stem}"] = lzma.decompress(raw) if module.suffix == ".xz" else raw
    written = CACHE / "initramfs.cpio.gz"
    with gzip.open(written, "wb", compresslevel=1) as archive:
        for folder in ("bin", "modules"):
            archive.write(_entry(folder, b"", 0o040755))
        for name, content in files.items():
            archive.write(_entry(name, content, 0o100755))
        archive.write(_entry("TRAILER!!!", b"", 0))
    return written


def in_order(modules: Path) -> list[Path]:
    """BEFORE_ROOT and what they need, in the order in which they can be loaded; what is built in is left out."""
    lines = [line.split(":") for line in (modules / "modules.dep").read_text().splitlines()]
    needs = {name: needed.split() for name, needed in lines}
    by_name = {Path(name).name.split(".")[0]: name for name in needs}
    order: list[str] = []
    for wanted in BEFORE_ROOT:
        for name in [*reversed(needs[by_name[wanted]]), by_name[wanted]] if wanted in by_name else []:
            order += [name] if name not in order else []
    return [modules / name for name in order]


def _entry(name: str, content: bytes, mode: int) -> bytes:
    """One file of a cpio archive (cpio(5), new portable format): thirteen hexadecimal fields, name and content padded to 4."""
    fields = (hash(name) & 0xFFFFFF, mode, 0, 0, 1, 0, len(content), 0, 0, 0, 0, len(name) + 1, 0)
    head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
    return head + bytes(-len(head) % 4) + content + bytes(-len(content) % 4)


def run_guest(initramfs: Path) -> int:
    """Boot, show what the guest says, and its tests' exit code. It is ended when its time is over."""
    guest = subprocess.Popen(_qemu(initramfs), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, errors="replace")
    over = threading.Timer(PATIENCE_S, guest.kill)
    over.start()
    try:
        code = relay(guest.stdout or ())
    finally:
        in_time = over.is_alive()
        over.cancel()
        guest.kill()
        guest.wait()
    if code is None:
        ended = "ended by itself" if in_time else f"was ended after {PATIENCE_S:g} s"
        print(f"make test-kernel: the guest {ended} before its tests did", file=sys.stderr)
    return 1 if code is None else code


def relay(lines: Iterable[str]) -> int | None:
    """Show the guest's lines, from its first own word on; the exit code it told. Never up: everything is shown."""
    unheard: list[str] = []
    up = False
    for line in lines:
        if found := re.search(r"KERNEL-GUEST exit (\d+)", line):
            return int(found[1])
        before, mark, said = line.rpartition("KERNEL-GUEST up: ")
        up = up or bool(mark)
        if up:
            print(said or before, end="", flush=True)
        else:
            unheard.append(line)
    print(*([] if up else unheard), sep="", file=sys.stderr)
    return None


def _qemu(initramfs: Path) -> list[str]:
    processors = min(max(os.cpu_count() or 2, 2), 4)
    return [
        *f"qemu-system-x86_64 -M pc -accel tcg,thread=multi,tb-size=512 -cpu max -smp {processors} -m 2G".split(),
        *["-nographic", "-no-reboot", "-nodefaults", "-serial", "stdio", "-device", "virtio-rng-pci"],
        *["-virtfs", "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap"],
        *("-kernel", str(LINUX / "boot" / f"vmlinuz-{release()}"), "-initrd", str(initramfs), "-append", COMMAND_LINE),
    ]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
