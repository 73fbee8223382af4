#!/usr/bin/env bash
# two_hosts_test.sh CASE SLUICE TOY: whole runs on two hosts (namespaces), and what ports a run opens.
set -euo pipefail
case=$1 sluice=$2 toy=$3
nap=""  # s that left sleeps in every window
# shellcheck source=tests/support/two_hosts.sh
. "$(dirname "$0")/../support/two_hosts.sh"

# scene NAME TOP LEFT RIGHT: two coupled masses; more keys for the top and for the two participants
scene() {
    cat >"$work/$1.yaml" <<EOF
sluice: 1
time: {end: 0.5, window: 0.001}
data: {place: {columns: {place: {unit: m}}}}
$2
participants:
  left: {command: $toy, $3 config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 1${nap:+, nap: $nap}}}
  right: {command: $toy, $4 config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 0}}
couplings:
  - {from: left, to: right, data: place}
  - {from: right, to: left, data: place, lag: 1, predict: linear}
EOF
}

hosts() { # hosts NAME SECURITY [MORE]
    scene "$1" "port: 5000
$2
${3:-}" "host: 10.71.0.1," "host: 10.71.0.2,"
}

one_host() { # what the run comes to on one host
    scene one "" "" ""
    on_a "$sluice" run "$work/one.yaml" --out "$work/one" --no-report --quiet >"$work/one.log" 2>&1 || fail "one host"
}

same_facts() { # same_facts DIRECTORY PARTICIPANT
    local expected
    expected=$(grep '"final place' "$work/one/.sluice/$2.json") || fail "no result of $2 on one host"
    [ "$expected" = "$(grep '"final place' "$1/.sluice/$2.json")" ] || fail "$2: not the bits of one host"
}

by_hand() { # by_hand SCENE: each on its host, with a directory of its own
    on_a "$toy" "$work/$1.yaml" --as left --out "$work/a" >"$work/left.log" 2>&1 &
    left=$!
    on_b "$toy" "$work/$1.yaml" --as right --out "$work/b" >"$work/right.log" 2>&1 &
    right=$!
}

over_the_network() {
    grep -q '"transport": "zmq"' "$work/a/.sluice/left.json" || fail "the hosts share memory"
}

# ports_of SCENE: every address that listens in the namespace while the run goes on
ports_of() {
    on_a "$sluice" run "$work/$1.yaml" --out "$work/$1" --no-report --quiet >"$work/$1.log" 2>&1 &
    local run=$!
    : >"$work/ports"
    while kill -0 "$run" 2>/dev/null; do
        on_a ss -ltnH | awk '{print $4}' >>"$work/ports"
        sleep 0.05
    done
    expect 0 "$run" "sluice run"
}

case $case in
    by_hand)
        one_host
        "$sluice" keygen "$work/keys" "$work/one.yaml" >"$work/keygen.log"
        hosts two "security: {keys: $work/keys}"
        by_hand two
        expect 0 "$left" left
        expect 0 "$right" right
        over_the_network
        same_facts "$work/a" left
        same_facts "$work/b" right
        ;;
    insecure)
        one_host
        hosts two "security: insecure"
        by_hand two
        expect 0 "$left" left
        expect 0 "$right" right
        over_the_network
        same_facts "$work/a" left
        ;;
    dies | lost) # kill -9 of one, or no network any more: the other one ends too, and says whom it lost
        nap=0.02
        "$sluice" keygen "$work/keys" left right >"$work/keygen.log"
        hosts two "security: {keys: $work/keys}" "timeouts: {silence: 2}"
        by_hand two
        for _ in $(seq 300); do
            window=$(od -An -t d8 -j 8 -N 8 "$work/b/.sluice/right.status" 2>/dev/null || true)
            [ "${window:-0}" -gt 3 ] && break || sleep 0.1
        done
        if [ "$case" = dies ]; then
            on_b pkill -KILL -f -- "--as right"
            expect 137 "$right" right
        else
            partition
            expect 3 "$right" right
            grep -q '^participant "left" is lost: no heartbeat for 2 s' "$work/right.log" || fail "right does not say why"
        fi
        expect 3 "$left" left
        grep -q '^participant "right" is lost: ' "$work/left.log" || fail "left does not say why"
        [ "$(wc -l <"$work/left.log")" = 1 ] || fail "more than one message"
        nobody_left
        ;;
    ports) # a default run opens no port, one over loopback none beyond it
        nap=0.002
        scene default "" "" ""
        ports_of default
        [ ! -s "$work/ports" ] || fail "a default run listens on $(sort -u "$work/ports" | tr '\n' ' ')"
        scene loopback "address: tcp://127.0.0.1:6000" "" ""
        ports_of loopback
        grep -q '^127.0.0.1:6001$' "$work/ports" || fail "nothing was seen to listen"
        if grep -v '^127\.' "$work/ports"; then fail "a run over loopback listens beyond it"; fi
        ;;
    strangers) # noise at the port of a run over loopback, before its participants meet and after
        one_host
        nap=0.002
        scene noisy "address: tcp://127.0.0.1:6000" "" ""
        on_a "$toy" "$work/noisy.yaml" --as left --out "$work/noisy" >"$work/left.log" 2>&1 &
        left=$!
        for _ in $(seq 200); do on_a ss -ltnH | grep -q :6001 && break || sleep 0.05; done
        on_a bash -c 'for n in $(seq 300); do head -c 3000 /dev/urandom >/dev/tcp/127.0.0.1/6001; done' 2>/dev/null ||
            true
        on_a "$toy" "$work/noisy.yaml" --as right --out "$work/noisy" >"$work/right.log" 2>&1 &
        right=$!
        while kill -0 "$right" 2>/dev/null; do
            on_a timeout 0.1 bash -c 'head -c 3000 /dev/urandom >/dev/tcp/127.0.0.1/6001' 2>/dev/null || true
        done
        expect 0 "$left" left
        expect 0 "$right" right
        same_facts "$work/noisy" left
        same_facts "$work/noisy" right
        ;;
    loss) # 5 % of the packets lost each way
        one_host
        on_a iptables -A INPUT -i "va$$" -m statistic --mode random --probability 0.05 -j DROP 2>"$work/why" ||
            skip "no random loss in this kernel"
        on_b iptables -A INPUT -i "vb$$" -m statistic --mode random --probability 0.05 -j DROP
        hosts two "security: insecure" "transport: zmq
timeouts: {silence: 20}"
        by_hand two
        expect 0 "$left" left
        expect 0 "$right" right
        same_facts "$work/a" left
        same_facts "$work/b" right
        [ "$(on_b iptables -nvxL INPUT | awk '/statistic/ {print $1}')" -gt 0 ] || fail "nothing was lost"
        ;;
    kill | partition) # the far participant is killed; nothing passes any more.
        nap=0.01
        hosts two "security: insecure" "transport: zmq
timeouts: {silence: 2}"
        by_hand two
        for _ in $(seq 200); do on_b ss -tnH state established | grep -q 10.71.0.1 && break || sleep 0.05; done
        sleep "1.$((RANDOM % 10))"
        begin=$(date +%s%N)
        if [ "$case" = kill ]; then
            on_b pkill -KILL -f -- "--as right"
        else
            partition
            expect 3 "$right" right
            grep -q 'participant "left" is lost: no heartbeat for 2 s (process [0-9]* on 10.71.0.1), while "right" was in window' \
                "$work/right.log" || fail "right does not say why"
        fi
        expect 3 "$left" left
        echo "ended after $((($(date +%s%N) - begin) / 1000000)) ms"
        grep -q 'participant "right" is lost: .*process [0-9]* on 10.71.0.2.*, while "left" was in window [0-9]* of 500 (t = ' \
            "$work/left.log" || fail "left does not say who"
        [ "$case" = kill ] || grep -q "no heartbeat for 2 s" "$work/left.log" || fail "left does not say why"
        ;;
    *) echo "no case $case" && exit 2 ;;
esac
echo "$case: ok"
