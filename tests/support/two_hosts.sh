# Two hosts for tests, a and b: a network, a table of processes, a name and mounts of their own each, joined by veth as
# 10.71.0.1 and 10.71.0.2, with one file system (as hosts that share one have). Source it; needs root. Ends the calling
# test as skipped (77), with the reason, where there can be none.
#
# Why process tables of their own: in one table both hosts' process ids mean the same, and memory can be shared.

skip() {
    echo "skipped: $*"
    exit 77
}

[ "$(id -u)" = 0 ] || skip "network namespaces need root"
for tool in ip ss iptables unshare nsenter; do
    command -v "$tool" >/dev/null || skip "$tool is not installed (iproute2, iptables, util-linux)"
done
A=sluice-a-$$
B=sluice-b-$$
host_a="" host_b=""  # the first process of each: ends all others there when it ends
work=$(mktemp -d /tmp/sluice-hosts-XXXXXX)

clean_up() {
    local first
    for first in $host_a $host_b; do kill -KILL "$first" 2>/dev/null || true; done
    ip netns delete "$A" 2>/dev/null || true
    ip netns delete "$B" 2>/dev/null || true
    rm -rf "$work"
}
trap clean_up EXIT

# The first process of a host: says its id and reaps what others leave behind.
first='hostname "$0" && mount -t tmpfs none /run && mkdir /run/sshd &&
printf "127.0.0.1 localhost\n10.71.0.1 host-a\n10.71.0.2 host-b\n" >/run/hosts && mount --bind /run/hosts /etc/hosts &&
: >"$UP" && unset UP && trap : TERM
while :; do sleep 1000 & wait $!; done'

# boot NAMESPACE NAME: $pid is its first process, seen from here
boot() {
    UP=$work/up-$2 ip netns exec "$1" unshare --pid --uts --mount --fork --kill-child --mount-proc \
        bash -c "$first" "$2" >"$work/why" 2>&1 &
    local holder=$! tries
    for tries in $(seq 200); do
        [ -e "$work/up-$2" ] && pid=$(pgrep -P "$holder") && return
        kill -0 "$holder" 2>/dev/null || break
        sleep 0.05
    done
    skip "no process namespace: $(cat "$work/why")"
}

ip netns add "$A" 2>"$work/why" || skip "no network namespace: $(cat "$work/why")"
ip netns add "$B"
ip link add "va$$" netns "$A" type veth peer name "vb$$" netns "$B" 2>"$work/why" || skip "no veth: $(cat "$work/why")"
ip -n "$A" address add 10.71.0.1/24 dev "va$$"
ip -n "$B" address add 10.71.0.2/24 dev "vb$$"
for side in "$A va$$" "$B vb$$"; do
    ip -n "${side% *}" link set lo up
    ip -n "${side% *}" link set "${side#* }" up
done
boot "$A" host-a && host_a=$pid
boot "$B" host-b && host_b=$pid

on_a() { nsenter -t "$host_a" -n -p -u -m --wdns="$PWD" -- "$@"; }
on_b() { nsenter -t "$host_b" -n -p -u -m --wdns="$PWD" -- "$@"; }

fail() {
    echo "FAILED: $*"
    for log in "$work"/*.log; do [ -e "$log" ] && echo "--- $log" && tail -n 20 "$log"; done
    exit 1
}

# expect CODE PROCESS NAME: waits for a process that was started here
expect() {
    local code=0
    wait "$2" || code=$?
    [ "$code" = "$1" ] || fail "$3 ended with exit $code (expected $1)"
}

# partition: no packet between the hosts any more; heal: again
partition() { on_b iptables -A INPUT -i "vb$$" -j DROP && on_b iptables -A OUTPUT -o "vb$$" -j DROP; }
heal() { on_b iptables -F; }

# left_on a|b: how many processes there have a file of this test's folder in their command line
left_on() { "on_$1" pgrep -cf "$work/" || true; }

# nobody_left: soon nothing runs on either host
nobody_left() {
    local tries
    for tries in $(seq 100); do
        [ "$(left_on a) $(left_on b)" = "0 0" ] && return
        sleep 0.1
    done
    on_a ps ax >"$work/a-processes.log"
    on_b ps ax >"$work/b-processes.log"
    fail "processes are left: $(left_on a) on a, $(left_on b) on b"
}
