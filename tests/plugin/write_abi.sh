#!/usr/bin/env bash
# Writes what a host relies on, as abidw (abigail-tools) describes it, of a released cosplat.h:
#
#   tests/plugin/write_abi.sh avatar/plugin/cosplat.h tests/golden/libcosplat_0.2.abi
#
# Once per release that changes the interface; the test plugin.abi compares the library with it. From
# the header alone, its functions with endless bodies, since the library would bring its own types.
set -euo pipefail
header=$1 out=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{
  echo "#include \"$(readlink -f "$header")\""
  ${CC:-cc} -E -P "$header" | tr '\n' ' ' | sed 's/;/;\n/g' |
    sed -n 's/^ *__attribute__((visibility("default"))) \(.*)\);$/\1 { for (;;) {} }/p'
} >"$work/stub.c"
(cd "$work" && ${CC:-cc} -g -O0 -fPIC -shared -fdebug-prefix-map="$work"=. stub.c -o libcosplat.so)
abidw --no-show-locs --no-corpus-path --no-comp-dir-path --no-elf-needed --no-parameter-names \
  --no-architecture --out-file "$out" "$work/libcosplat.so"
