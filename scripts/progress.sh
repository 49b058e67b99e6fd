# Sourced by run.sh and setup.sh: shows what a command does while it runs.

# progress TITLE EXPECTED_SECONDS COMMAND...: on a terminal a bar, in a log a line at least every ten seconds. Counts what
# Ninja says, "[12/51] ...", and what apt does. What the command writes is kept; after a failure all of it is shown.
progress() {
    local title=$1 expected=$2 log begin=$SECONDS status=0
    shift 2
    log=$(mktemp)
    # shellcheck disable=SC2094
    { NINJA_STATUS='[%f/%t] ' "$@" 2>&1; printf '\001%s\n' $?; } | {
        local line done_count=0 total=0 unpacked=0 ready=0 shown=-100 now doing= status=1 more=yes
        while [ $more = yes ]; do
            if IFS= read -r -t 1 line; then
                case $line in
                $'\001'*) status=${line#?}; more=no ;;  # no command's own words begin so
                *) printf '%s\n' "$line" >>"$log" ;;
                esac
                if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\ (.*) ]]; then
                    done_count=${BASH_REMATCH[1]} total=${BASH_REMATCH[2]} doing=$(short_name "${BASH_REMATCH[3]}")
                elif [[ $line =~ ^(Get:|Unpacking|Setting\ up) ]]; then
                    [ "${BASH_REMATCH[1]}" != Unpacking ] || unpacked=$((unpacked + 1))
                    [ "${BASH_REMATCH[1]}" != "Setting up" ] || ready=$((ready + 1))
                    doing="$unpacked packages unpacked, $ready set up"
                fi
            elif [ $? -le 128 ]; then
                more=no
            fi
            now=$((SECONDS - begin))
            if [ -t 2 ]; then
                [ $more = no ] || printf '\r\033[K%s' "$(progress_line "$title" $done_count $total $now "$expected" "$doing" bar)" >&2
            elif [ $more = yes ] && [ $((now - shown)) -ge 8 ]; then
                shown=$now
                progress_line "$title" $done_count $total $now "$expected" "$doing" >&2
            fi
        done
        [ ! -t 2 ] || printf '\r\033[K' >&2
        exit "$status"
    } || status=$?
    if [ $status = 0 ]; then
        printf '%s: done in %s\n' "$title" "$(minutes $((SECONDS - begin)))" >&2
        # Of a warning of CMake the lines below it say what is wrong.
        awk '/CMake Warning/ {print; below = 1; next} below && /^(  |$)/ {if (NF) print; next}
             {below = 0} /warning: |^WARNING/' "$log" >&2
    else
        cat "$log" >&2
        printf '%s: failed, status %d (what it wrote is above)\n' "$title" $status >&2
    fi
    rm -f "$log"
    return $status
}

progress_line() {  # TITLE DONE TOTAL SECONDS EXPECTED_SECONDS DOING [bar]
    local title=$1 done_count=$2 total=$3 now=$4 left=$(($5 - $4)) words=$1 bar= width=20
    # What is left, as long as what was done took; before a tenth is done, as long as such a build took elsewhere.
    [ "$total" = 0 ] || [ $((10 * done_count)) -lt "$total" ] || left=$((now * (total - done_count) / (done_count > 0 ? done_count : 1)))
    if [ "$total" -gt 0 ]; then
        if [ "${7-}" = bar ]; then
            bar=$(printf '%*s' $((width * done_count / total)) '')
            words+=" [${bar// /#}$(printf '%*s' $((width - width * done_count / total)) '')]"
        fi
        words+=" $done_count of $total"
    fi
    words+=", $(minutes "$now")"
    [ $left -le 0 ] || words+=", about $(minutes $left) left"
    [ -z "$6" ] || words+=" ($6)"
    [ "${7-}" != bar ] || words=${words:0:$((${COLUMNS:-$(tput cols 2>/dev/null || echo 80)} - 1))}
    printf '%s\n' "$words"
}

minutes() {  # SECONDS
    if [ "$1" -lt 90 ]; then echo "$1 s"; else echo "$((($1 + 30) / 60)) min"; fi
}

# Of "Building CXX object core/mesh/CMakeFiles/strake_mesh.dir/Unity/unity_0_cxx.cxx.o": strake_mesh
short_name() {
    local name=$1
    case $name in
    *.dir/*) name=${name%%.dir/*} ;;
    esac
    name=${name##*/}
    echo "${name##* }"
}
