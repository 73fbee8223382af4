# Two hosts for tests: network namespaces $A and $B joined by veth, 10.71.0.1 and 10.71.0.2. Source it; needs root.
# Ends the calling test as skipped (77), with the reason, where there can be none.

skip() {
    echo "skipped: $*"
    exit 77
}

[ "$(id -u)" = 0 ] || skip "network namespaces need root"
for tool in ip ss iptables; do
    command -v "$tool" >/dev/null || skip "$tool is not installed (iproute2, iptables)"
done
A=sluice-a-$$
B=sluice-b-$$
work=$(mktemp -d /tmp/sluice-hosts-XXXXXX)
started=""

clean_up() {
    local process
    for process in $started; do kill "$process" 2>/dev/null || true; done
    ip netns delete "$A" 2>/dev/null || true
    ip netns delete "$B" 2>/dev/null || true
    rm -rf "$work"
}
trap clean_up EXIT

ip netns add "$A" 2>"$work/why" || skip "no network namespace: $(cat "$work/why")"
ip netns add "$B"
ip link add "va$$" netns "$A" type veth peer name "vb$$" netns "$B" 2>"$work/why" || skip "no veth: $(cat "$work/why")"
ip -n "$A" address add 10.71.0.1/24 dev "va$$"
ip -n "$B" address add 10.71.0.2/24 dev "vb$$"
for side in "$A va$$" "$B vb$$"; do
    ip -n "${side% *}" link set lo up
    ip -n "${side% *}" link set "${side#* }" up
done

on_a() { ip netns exec "$A" "$@"; }
on_b() { ip netns exec "$B" "$@"; }

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
