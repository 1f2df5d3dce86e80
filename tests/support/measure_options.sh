# Sourced by the scripts that measure trainings, with `set -euo pipefail`, once they have set the
# names of their `arguments` and the defaults of divisor and iterations: reads ARGUMENTS... [-r N]
# [--iterations N] [--keep FOLDER] [-- OPTIONS] into variables of those names, divisor, iterations
# and the array options, and makes $work, the folder of the runs, which goes when the script ends
# unless --keep names it. Anything else prints the comment that the script begins with.
# shellcheck shell=bash
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2; }

# figure NAME FILE: the last number of that name in a results.json or stats.json.
figure() { sed -n "s/^ *\"$1\": \([0-9.]*\),*$/\1/p" "$2" | tail -n 1; }

for name in "${arguments[@]}"; do
  [[ $# -gt 0 ]] || usage
  printf -v "$name" %s "$1"
  shift
done
keep=
while [[ $# -gt 0 ]]; do
  case $1 in
    -r | --iterations | --keep)
      [[ $# -ge 2 ]] || usage
      case $1 in -r) divisor=$2 ;; --iterations) iterations=$2 ;; --keep) keep=$2 ;; esac
      shift 2
      ;;
    --) shift; break ;;
    *) usage ;;
  esac
done
options=("$@")
work=${keep:-$(mktemp -d)}
mkdir -p "$work"
[[ -n $keep ]] || trap 'rm -rf "$work"' EXIT
