# Sourced by scripts that measure trainings of a scene, after they have set `divisor` and `iterations`
# to their defaults and defined `usage`. Reads `-r N`, `--iterations N`, `--keep FOLDER` and what
# follows `--` from the arguments, and sets besides those
#   work      where data and runs go: the folder of --keep, or one that is removed at the end
#   options   array: of train-scene, for all trainings
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
