#!/usr/bin/env bash
# Does the project build and pass on another Debian? Makes a bare system of a release in a folder, clones
# the last commit into it, does there what the README says, and prints a table.
set -euo pipefail

root=$(git -C "$(dirname "${BASH_SOURCE[0]}")" rev-parse --show-toplevel)
name=tests/machines/run.sh

show_help() {
  cat <<'TEXT'
tests/machines/run.sh RELEASE [OPTIONS]   as root

RELEASE is a Debian release: 12, 13, sid, or another that debootstrap knows by its code name.

  --folder DIR      where systems and logs are kept (default: out/machines in the checkout); a second
                    call reuses the system, and builds from the beginning
  --compiler C++    another compiler than g++, e.g. clang++ (its package is installed)
  --quick           builds `cosplat` and the quick tests only, and runs these in place of all
  --web             builds the browser's player too, and runs its tests in that system's Chromium
                    and Firefox
  --deb             builds cosplat.deb too, and installs it in another bare system
  --no-demo         leaves the demo out
  --mirror ADDRESS  where packages come from (default: where this machine's apt has them from)
  --ccache DIR      keeps compiler output there between calls (ccache is installed)

The system is a folder: it shares this machine's kernel and network, and nothing is mounted outside
of the call. The last commit is what is tried; what is not committed is not.
TEXT
}

fail() {
  echo "$name: $*" >&2
  exit 1
}

release=
folder=$root/out/machines
compiler=
quick=0
web=0
deb=0
with_demo=1
mirror=
ccache=
while [[ $# -gt 0 ]]; do
  case $1 in
    -h | --help) show_help; exit 0 ;;
    --quick) quick=1; shift ;;
    --web) web=1; shift ;;
    --deb) deb=1; shift ;;
    --no-demo) with_demo=0; shift ;;
    --folder | --compiler | --mirror | --ccache)
      [[ $# -ge 2 && -n $2 ]] || fail "$1 needs a value"
      declare "${1#--}=$2"
      shift 2 ;;
    -*) fail "there is no option '$1'; see --help" ;;
    *) [[ -z $release ]] || fail "one release at a time, not '$release' and '$1'"; release=$1; shift ;;
  esac
done
[[ -n $release ]] || { show_help >&2; exit 2; }
[[ $(id -u) -eq 0 ]] || fail "a system in a folder needs root"

case $release in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) suite=$release ;;
esac
command -v debootstrap >/dev/null || fail "debootstrap is missing; apt-get install debootstrap"
[[ -e /usr/share/debootstrap/scripts/$suite ]] || fail "debootstrap knows no release '$release'"
if [[ -z $mirror ]]; then
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Origin: Debian' 'Created-By: Packages' |
    grep -v security | head -n 1 || true)
  [[ -n $mirror ]] || fail "this machine's apt has no source of Debian's packages; give one with --mirror"
fi
mkdir -p "$folder"
folder=$(readlink -f "$folder")
system=$folder/$release
log=$folder/$release${compiler:+-$compiler}.log
: >"$log"

# in_system SYSTEM COMMAND: as root there, with a clean environment, in mounts of its own that end with
# the command. Name resolution, proxies and certificates are this machine's.
in_system() {
  local variable kept=()
  for variable in http_proxy https_proxy; do
    [[ -z ${!variable:-} ]] || kept+=("$variable=${!variable}")
  done
  [[ -z $compiler ]] || kept+=("CXX=$compiler")
  [[ -z $ccache ]] || kept+=("CCACHE_DIR=/var/cache/ccache" CCACHE_BASEDIR=/root
    CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros)
  cp /etc/resolv.conf "$1/etc/resolv.conf"
  if [[ -e /etc/ssl/certs/ca-certificates.crt ]]; then
    cp /etc/ssl/certs/ca-certificates.crt "$1/etc/machine-certificates.crt"
    kept+=("NODE_EXTRA_CA_CERTS=/etc/machine-certificates.crt")
  fi
  # shellcheck disable=SC2016
  unshare --mount --pid --fork bash -c '
    set -e
    system=$1 ccache=$2
    shift 2
    mount --rbind /dev "$system/dev"
    mount -t proc proc "$system/proc"
    mount -t tmpfs tmpfs "$system/tmp"
    mount -t tmpfs tmpfs "$system/run"
    if [[ -n $ccache ]]; then
      mkdir -p "$ccache" "$system/var/cache/ccache"
      mount --bind "$ccache" "$system/var/cache/ccache"
    fi
    exec chroot "$system" "$@"' machine "$1" "$ccache" \
    /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 "${kept[@]}" \
    bash -c "cd /root; $2"
}

# make_system SYSTEM: a bare one, unless it is there.
make_system() {
  [[ -e $1/.complete ]] && return
  rm -rf --one-file-system "$1"
  echo "Making a bare system of $release" >&2
  debootstrap --variant=minbase "$suite" "$1" "$mirror" >>"$log" 2>&1 ||
    fail "debootstrap failed; its log is $log"
  # As in images of containers: a write to disk after each file would take most of the time.
  echo force-unsafe-io >"$1/etc/dpkg/dpkg.cfg.d/machine"
  # Release files of a source that lags behind have run out; packages are still checked by their sums.
  echo 'Acquire::Check-Valid-Until "false";' >"$1/etc/apt/apt.conf.d/80machine"
  # Proxies and the like.
  apt-config dump Acquire >"$1/etc/apt/apt.conf.d/90machine"
  if [[ $suite != sid ]]; then
    echo "deb $mirror $suite-updates main" >>"$1/etc/apt/sources.list"
  fi
  touch "$1/.complete"
}

# step NAME COMMAND: in the system, into the log; its seconds in `seconds`, its exit status in `status`.
step() {
  echo "$1" >&2
  echo "== $1: $2" >>"$log"
  local start=$SECONDS
  status=0
  in_system "$system" "$2" >>"$log" 2>&1 </dev/null || status=$?
  seconds=$((SECONDS - start))
}

rows=()
row() { rows+=("| $1 | $2 |"); }
failed=0
# outcome TEXT: a row's text, with what went wrong if anything did.
outcome() {
  if [[ $status -eq 0 ]]; then
    echo "$1"
  else
    echo "$1: **failed** (status $status)"
  fi
}

make_system "$system"
extra=(git)
[[ -z $ccache ]] || extra+=(ccache)
[[ $web -eq 0 ]] || extra+=(python3 python3-numpy firefox-esr xvfb xauth libgl1-mesa-dri)
[[ -z $compiler ]] || extra+=("${compiler%++}")
step "Bringing the system up to date" \
  "export DEBIAN_FRONTEND=noninteractive; apt-get update && apt-get -y upgrade &&
   apt-get install -y --no-install-recommends ${extra[*]}"
[[ $status -eq 0 ]] || fail "the system could not be brought up to date; the log is $log"
rm -rf "$system/root/cosplat"
git clone --quiet --no-hardlinks "$root" "$system/root/cosplat"
row "commit" "$(git -C "$root" rev-parse --short HEAD)"

before=$(in_system "$system" "dpkg-query -W | wc -l")
step "Installing packages" "cosplat/run packages$([[ $quick -eq 1 ]] || echo ' --tests')"
packages=$(($(in_system "$system" "dpkg-query -W | wc -l") - before))
row "system" "Debian $(cat "$system/etc/debian_version"), $(in_system "$system" '${CXX:-g++} --version 2>/dev/null | head -n 1' || true)"
row "packages" "$(outcome "$packages new in $seconds s")"
[[ $status -eq 0 ]] || failed=1
if [[ $quick -eq 1 ]]; then
  step "Building and running the quick tests" "cosplat/run test --quick"
else
  step "Building" "cosplat/run build"
  row "build" "$(outcome "$seconds s")"
  [[ $status -eq 0 ]] || failed=1
  step "The tests" "cosplat/run test"
fi
tests=$(sed -n 's/^\([0-9]*% tests passed, [0-9]* tests failed out of [0-9]*\).*/\1/p' "$log" | tail -n 1)
last=$system/root/cosplat/build/cpu/Testing/Temporary/LastTest.log
# GoogleTest prints a skipped test's reason in the line below `FILE:LINE: Skipped`.
reasons=$(grep -h -A 1 ': Skipped$' "$last" 2>/dev/null | grep -v -e ': Skipped$' -e '^--$' |
  sort | uniq -c | sort -rn || true)
row "tests" "$(outcome "${tests:-none ran}, in $seconds s")"
[[ $status -eq 0 ]] || failed=1

if [[ $with_demo -eq 1 ]]; then
  step "The demo" "cosplat/run demo"
  psnr=$(sed -n 's/.*PSNR \([0-9.]*\) dB.*/\1/p' "$log" | tail -n 1)
  row "demo" "$(outcome "$seconds s, ${psnr:-no} dB")"
  [[ $status -eq 0 ]] || failed=1
fi

if [[ $web -eq 1 ]]; then
  step "The browser's player" "cosplat/run web && cd cosplat && cmake --preset cpu &&
    cmake --build build/cpu --parallel $(nproc) --target cosplat cosplat_plugin &&
    ctest --test-dir build/cpu --output-on-failure --tests-regex '^web[.]'"
  tests=$(sed -n '/^== The browser/,$ s/^\([0-9]*% tests passed, [0-9]* tests failed out of [0-9]*\).*/\1/p' "$log" | tail -n 1)
  row "browser" "$(outcome "${tests:-none ran}, in $seconds s")"
  [[ $status -eq 0 ]] || failed=1
fi

if [[ $deb -eq 1 ]]; then
  step "Building cosplat.deb" "cosplat/run deb"
  row "cosplat.deb" "$(outcome "$seconds s")"
  if [[ $status -eq 0 ]]; then
    built=$system/root/cosplat/build/deb/cosplat.deb
    fresh=$folder/$release-fresh
    make_system "$fresh"
    cp "$built" "$fresh/root/"
    system=$fresh
    step "Installing cosplat.deb in another bare system" \
      "export DEBIAN_FRONTEND=noninteractive; apt-get update && apt-get install -y --no-install-recommends ./cosplat.deb && cosplat --version &&
       cosplat make-head -o head --frames 4 --test-frames 1 && apt-get purge -y cosplat"
    row "installed from it" "$(outcome "$seconds s")"
  fi
  [[ $status -eq 0 ]] || failed=1
fi

{
  echo
  echo "| | |"
  echo "|---|---|"
  printf '%s\n' "${rows[@]}"
  if [[ -n $reasons ]]; then
    echo
    echo "Tests skipped, by reason:"
    echo "$reasons"
  fi
} | tee -a "$log"
if [[ $failed -ne 0 ]]; then tail -n 60 "$log" >&2; fi
echo "The log is $log" >&2
exit "$failed"
