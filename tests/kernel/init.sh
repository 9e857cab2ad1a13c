#!/bin/busybox sh
# First program of the guest, from the initramfs: mounts the host's files read-only by 9p, puts a tmpfs above them and
# goes on as guest.sh inside. Nothing the guest does reaches the host.
B=/bin/busybox
fail() { echo "KERNEL-GUEST failed: $1"; $B poweroff -f; }
$B mkdir -p /proc /sys /dev /host /over /root
$B mount -t proc proc /proc; $B mount -t sysfs sys /sys; $B mount -t devtmpfs dev /dev
for module in /modules/*; do $B insmod "$module" || fail "insmod $module"; done
$B mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose,ro host /host || fail "no 9p"
$B mount -t tmpfs over /over; $B mkdir /over/upper /over/work
$B mount -t overlay -o lowerdir=/host,upperdir=/over/upper,workdir=/over/work overlay /root || fail "no overlay"
for place in dev proc sys; do $B mount --move /$place /root/$place; done
$B mkdir -p /root/dev/pts /root/dev/shm /root/run
$B mount -t devpts pts /root/dev/pts
for place in dev/shm run; do $B mount -t tmpfs tmpfs /root/$place; done
$B cp /arguments /root/run/arguments
exec $B switch_root /root /bin/sh "$($B head -1 /arguments)/tests/kernel/guest.sh"
