# Completion of `sluice` for bash: commands, options, scenes, paths of --set, templates, runs.
# Installed as /usr/share/bash-completion/completions/sluice; or: source sluice.bash

# The options of a command. A test compares this list with what `sluice COMMAND --help` says.
_sluice_options() {
    case $1 in
        run | record) echo "--set --out --quiet --no-report --json" ;;
        check) echo "--set --quiet --json" ;;
        graph) echo "--set --output --json" ;;
        schema) echo "--output --paths" ;;
        watch) echo "--json --once" ;;
        report) echo "--output --json" ;;
        resume) echo "--set --quiet --no-report --json" ;;
        replay) echo "--only --set --out --quiet --no-report" ;;
        doctor | explain) echo "--json" ;;
    esac
}

# Files that end as one of the words after $1 say, and directories; all files if none is given.
_sluice_files() {
    local current=$1 file
    shift
    compopt -o filenames 2>/dev/null
    while IFS= read -r file; do
        if [ -d "$file" ]; then
            COMPREPLY+=("$file")
            continue
        fi
        local ending fits=$(( $# == 0 ))
        for ending in "$@"; do [[ $file == *"$ending" ]] && fits=1; done
        (( fits )) && COMPREPLY+=("$file")
    done < <(compgen -f -- "$current")
}

_sluice_directories() {
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -d -- "$1")
}

# path= for each path of the scene on the command line.
_sluice_set() {
    local word scene=""
    for word in "${COMP_WORDS[@]:2}"; do [[ $word == *.yaml || $word == *.yml ]] && scene=$word; done
    [ -f "$scene" ] || return
    compopt -o nospace 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" schema --paths "$scene" 2>/dev/null | sed 's/$/=/')" -- "$1")
}

_sluice_words() {
    mapfile -t COMPREPLY < <(compgen -W "$1" -- "$2")
}

_sluice() {
    COMPREPLY=()
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
    if (( COMP_CWORD == 1 )); then
        _sluice_words "run resume record replay check graph schema keygen watch report init doctor explain --help --version" "$current"
        return
    fi
    case $previous in
        --set) _sluice_set "$current"; return ;;
        --out) _sluice_directories "$current"; return ;;
        --paths) _sluice_files "$current" .yaml .yml; return ;;
        -o | --output) _sluice_files "$current"; return ;;
    esac
    if [[ $current == -* ]]; then
        _sluice_words "$(_sluice_options "$command") --help" "$current"
        return
    fi
    case $command in
        run | record | check | graph) _sluice_files "$current" .yaml .yml ;;
        resume | replay | watch | report) _sluice_directories "$current" ;;
        init)
            if (( COMP_CWORD == 2 )); then
                _sluice_words "$("${COMP_WORDS[0]}" init 2>/dev/null)" "$current"
            else
                _sluice_directories "$current"
            fi ;;
        explain)
            _sluice_words "$("${COMP_WORDS[0]}" explain 2>/dev/null | sed -E 's/^([0-9]+) \(([a-z]+)\).*/\1 \2/; s/^([a-z]+) .*/\1/')" "$current" ;;
    esac
}

complete -F _sluice sluice
