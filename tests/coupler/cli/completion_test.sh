#!/usr/bin/env bash
# completion_test.sh SLUICE COMPLETION: calls the completion function as bash does, and compares its lists with --help.
set -u
sluice=$1
PATH=$(dirname "$sluice"):$PATH
source "$2"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
mkdir runs
printf 'sluice: 1\ntime: {end: 1}\nparticipants: {a: {solver: s}, b: {solver: s}}\ncouplings: [{from: a, to: b, data: load}]\n' >scene.yaml
touch notes.txt
failed=0

# expect COMMAND-LINE WORD...: completing the last word of the line gives exactly these.
expect() {
    read -r -a COMP_WORDS <<<"$1"
    [[ $1 == *" " ]] && COMP_WORDS+=("")
    COMP_CWORD=$(( ${#COMP_WORDS[@]} - 1 ))
    shift
    _sluice
    local found wanted
    found=$(printf '%s\n' "${COMPREPLY[@]}" | sort)
    wanted=$(printf '%s\n' "$@" | sort)
    if [ "$found" != "$wanted" ]; then
        echo "completing \"${COMP_WORDS[*]}\": got $(echo "$found" | tr '\n' ' ')(needed: $(echo "$wanted" | tr '\n' ' '))"
        failed=1
    fi
}

expect "sluice rep" replay report
expect "sluice c" check
expect "sluice run --q" --quiet
expect "sluice check " scene.yaml runs
expect "sluice watch " runs
expect "sluice run scene.yaml --set time." time.end= time.window= time.pace=
expect "sluice run scene.yaml --set couplings.0.l" couplings.0.lag=
expect "sluice run scene.yaml --out r" runs
expect "sluice init d" dry_column
expect "sluice explain 7" 7 70 75
expect "sluice explain circ" circle
expect "sluice graph scene.yaml -o no" notes.txt
expect "sluice check no"

# The lists are those of the command itself.
_sluice_all() { COMP_WORDS=(sluice "") COMP_CWORD=1; _sluice; printf '%s\n' "${COMPREPLY[@]}" | grep -v '^-' | sort; }
commands=$("$sluice" --help | sed -n '/^Subcommands:/,$p' | sed -nE 's/^  ([a-z]+) .*/\1/p' | sort)
if [ -z "$commands" ] || [ "$commands" != "$(_sluice_all)" ]; then
    echo "commands: --help has $(echo $commands), completion $(echo $(_sluice_all))"
    failed=1
fi
for command in $commands; do
    told=$("$sluice" "$command" --help | sed -nE 's/^  (-[a-z],)?(--[a-z-]+).*/\2/p' | grep -vx -- --help | sort -u)
    listed=$(_sluice_options "$command" | tr ' ' '\n' | sed '/^$/d' | sort -u)
    if [ "$told" != "$listed" ]; then
        echo "options of $command: --help has $(echo $told), completion $(echo $listed)"
        failed=1
    fi
done
[ $failed = 0 ] && echo "completion: $(echo $commands)"
exit $failed
