#!/usr/bin/env bash
# two_hosts_test.sh CASE MEMBER SLUICE: the ZeroMQ transport between two hosts, with keys, and what the network does to it.
set -euo pipefail
case=$1 member=$2 sluice=$3
# shellcheck source=tests/support/two_hosts.sh
. "$(dirname "$0")/../support/two_hosts.sh"
"$sluice" keygen "$work/keys" a b >"$work/keygen.log"

# start a|b SELF KEYS SILENCE ROUNDS PAUSE: in the background; $pid
start() {
    local host=$1 self=$2
    shift 2
    "on_$host" "$member" "$self" 10.71.0.1 10.71.0.2 5000 "$@" >"$work/$self.log" 2>&1 &
    pid=$!
}

both() { # both KEYS SILENCE ROUNDS PAUSE
    start a 0 "$@" && pid_a=$pid
    start b 1 "$@" && pid_b=$pid
}

same_hash() {
    expect 0 "$pid_a" a
    expect 0 "$pid_b" b
    grep -q '^done ' "$work/0.log" || fail "no result"
    cmp -s "$work/0.log" "$work/1.log" || fail "the two sides differ"
}

reference() { # reference ROUNDS: what the same conversation comes to on one host
    local reference_pid
    on_a "$member" 0 127.0.0.1 127.0.0.1 7000 - 5000 "$1" 0 >"$work/one.log" 2>&1 &
    reference_pid=$!
    on_a "$member" 1 127.0.0.1 127.0.0.1 7000 - 5000 "$1" 0 >"$work/other.log" 2>&1
    wait "$reference_pid"
}

underway() { # until both have met
    local tries
    for tries in $(seq 200); do
        on_b ss -tnH state established | grep -q 10.71.0.1 && sleep 1 && return
        sleep 0.1
    done
    fail "no connection"
}

case $case in
    same_bits) # tcp and CURVE between two hosts give what one host gives
        reference 300
        both "$work/keys" 5000 300 0
        same_hash
        cmp "$work/0.log" "$work/one.log" || fail "not the bits of one host"
        ;;
    loss) # 5 % of the packets lost each way
        on_a iptables -A INPUT -i "va$$" -m statistic --mode random --probability 0.05 -j DROP ||
            skip "no random loss in this kernel"
        on_b iptables -A INPUT -i "vb$$" -m statistic --mode random --probability 0.05 -j DROP
        reference 100
        both "$work/keys" 20000 100 0
        same_hash
        cmp "$work/0.log" "$work/one.log" || fail "not the bits of one host"
        [ "$(on_b iptables -nvxL INPUT | awk '/statistic/ {print $1}')" -gt 0 ] || fail "nothing was lost"
        ;;
    short_partition) # 1 s, less than the silence
        reference 300
        both "$work/keys" 5000 300 10
        underway
        partition
        sleep 1
        heal
        same_hash
        cmp "$work/0.log" "$work/one.log" || fail "not the bits of one host"
        ;;
    long_partition) # both sides say so and neither goes on
        both "$work/keys" 2000 100000 1
        underway
        partition
        expect 3 "$pid_a" a
        expect 3 "$pid_b" b
        for side in 0 1; do grep -q '^lost: no heartbeat for 2 s' "$work/$side.log" || fail "side $side does not say why"; done
        ;;
    wrong_key) # b shows a key that a does not know
        "$sluice" keygen "$work/other" b >"$work/keygen.log"
        mkdir "$work/mixed" && cp -p "$work"/keys/a.* "$work/other"/b.* "$work/mixed"
        start a 0 "$work/keys" 2000 10 0 && pid_a=$pid
        start b 1 "$work/mixed" 2000 10 0 && pid_b=$pid
        expect 4 "$pid_a" a
        expect 4 "$pid_b" b
        grep -qF "unknown key $(cat "$work/other/b.public")" "$work/0.log" || fail "a does not say why"
        grep -q "key is not in its allow-list" "$work/1.log" || fail "b does not say why"
        ;;
    wrong_host) # a participant started where it does not belong
        code=0
        on_b "$member" 0 10.71.0.1 10.71.0.2 5000 "$work/keys" 2000 10 0 >"$work/0.log" 2>&1 || code=$?
        [ "$code" = 7 ] || fail "exit $code (expected 7)"
        grep -q "host 10.71.0.1 is not an address of this machine" "$work/0.log" || fail "does not say why"
        ;;
    *) echo "no case $case" && exit 2 ;;
esac
if grep -qF -f <(cat "$work"/keys/*.secret) "$work"/*.log; then fail "a secret was printed"; fi
echo "$case: ok"
