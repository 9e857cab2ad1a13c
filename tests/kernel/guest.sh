# Process 1 of the guest: modules, loopback, the tests. What they said goes out by the serial line; then power off.
# /run/arguments: the repository, then the arguments of pytest, one a line.
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8
IFS='
'
set -- $(cat /run/arguments)
cd "$1" && shift
modprobe -d .kernel/linux -a vcan can-raw uinput evdev veth sch_netem
ip link set lo up
echo "KERNEL-GUEST up: kernel $(uname -r) after $(cut -d' ' -f1 /proc/uptime) s"
.venv/bin/python tests/kernel/starter.py /run/starter &
PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 .venv/bin/pytest -p no:cacheprovider --color=no -vv tests/kernel "$@"
echo "KERNEL-GUEST exit $?"
echo o > /proc/sysrq-trigger
while :; do :; done
