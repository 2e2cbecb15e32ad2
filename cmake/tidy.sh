#!/usr/bin/env bash
# clang-tidy over the C++ files that changed since a revision, by default the last release's tag. Where there is no tag,
# over those of the last commits, newest first. `.clang-tidy` has the rules.
#   cmake/tidy.sh [--minutes N] [REVISION]
# After N minutes (default: 6) no further file is begun, and it says how many were left out.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

minutes=6
if [[ ${1-} == --minutes ]]; then
    minutes=${2:?how many minutes}
    shift 2
fi
since=${1-$(git describe --tags --abbrev=0 --match 'v*' 2>/dev/null || true)}

# clang-tidy takes its own rules where it cannot read these, and passes.
complaint=$(clang-tidy-14 --dump-config 2>&1 >/dev/null)
[[ -z $complaint ]] || { printf '%s\n' "$complaint" >&2 && exit 2; }

# The preset's commands are those of a build without precompiled headers, which clang could not read.
cmake --preset debug >/dev/null

changed_files() {
    if [[ -n $since ]]; then
        git diff --name-only --diff-filter=d "$since" -- '*.cpp'
    else
        git log --format= --name-only -- '*.cpp' | awk '!seen[$0]++'
    fi
}

# Only of what is compiled are the flags known.
files=()
while read -r file; do
    [[ -e $file ]] && grep -qF "\"file\": \"$root/$file\"" build-debug/compile_commands.json && files+=("$file")
done < <(changed_files)
((${#files[@]})) || { printf 'tidy: nothing has changed since %s\n' "${since:-ever}" && exit; }
order=${since:+changed since $since}
printf 'tidy: %d files, %s\n' "${#files[@]}" "${order:-those of the last commits first}"

left_out=$(mktemp)
trap 'rm -f "$left_out"' EXIT
tidy() {
    if (($(date +%s) >= deadline)); then
        printf '%s\n' "$1" >>"$left_out"
        return
    fi
    local output
    output=$(clang-tidy-14 -p build-debug --quiet "$1" 2>&1) || { printf '%s\n' "$output" && return 1; }
}
export -f tidy
export left_out deadline=$(($(date +%s) + 60 * minutes))
result=0
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" bash -c 'tidy "$1"' tidy || result=1
printf 'tidy: %d left out after %s minutes\n' "$(wc -l <"$left_out")" "$minutes"
exit "$result"
