#!/usr/bin/env bash
# OBS Studio itself (Debian: obs-studio, xvfb, imagemagick), on a virtual display, with a scene
# collection that has the avatar as a source, driven by `cosplat send`. Keeps a screenshot and OBS's
# log, and says what became of OBS's memory.
#
#   tests/hosts/obs_studio.sh --build build/cpu --avatar avatar.glb --head FOLDER --out DIR [--minutes 10]
#
# FOLDER: of `cosplat make-head`, whose model and motion are used. Ends with 1 if OBS ended early, its
# log has an error of the source, the tracker's frames did not arrive, or the picture is empty.
set -euo pipefail
root=$(readlink -f "$(dirname "${BASH_SOURCE[0]}")/../..")
minutes=10
while [[ $# -gt 0 ]]; do
  case $1 in
    --build) build=$(readlink -f "$2") ;;
    --avatar) avatar=$(readlink -f "$2") ;;
    --head) head=$(readlink -f "$2") ;;
    --out) mkdir -p "$2" && out=$(readlink -f "$2") ;;
    --minutes) minutes=$2 ;;
    *) sed -n '2,/^set/p' "$0" | sed '$d; s/^# \?//' >&2; exit 2 ;;
  esac
  shift 2
done
port=$((20000 + RANDOM % 20000))

# OBS as its user left it: our module, one profile, one scene collection.
export HOME=$out/home
rm -rf "$HOME"
config=$HOME/.config/obs-studio
mkdir -p "$config/plugins/cosplat/bin" "$config/basic/scenes" "$config/basic/profiles/CoSplat"
ln -s "$build/apps/obs" "$config/plugins/cosplat/bin/64bit"
ln -s "$root/apps/obs/data" "$config/plugins/cosplat/data"
cat >"$config/global.ini" <<INI
[General]
FirstRun=true
LastVersion=486539266
EnableAutoUpdates=false
[Basic]
Profile=CoSplat
ProfileDir=CoSplat
SceneCollection=CoSplat
SceneCollectionFile=CoSplat
INI
cat >"$config/basic/profiles/CoSplat/basic.ini" <<INI
[General]
Name=CoSplat
[Video]
BaseCX=640
BaseCY=512
OutputCX=640
OutputCY=512
FPSType=0
FPSCommon=30
INI
cat >"$config/basic/scenes/CoSplat.json" <<JSON
{"name": "CoSplat", "current_scene": "Scene", "current_program_scene": "Scene",
 "scene_order": [{"name": "Scene"}],
 "sources": [
  {"id": "cosplat_avatar", "versioned_id": "cosplat_avatar", "name": "Avatar", "enabled": true,
   "settings": {"avatar": "$avatar", "flame": "$head/model.npz", "drive": "udp://127.0.0.1:$port",
                "background": "color"}},
  {"id": "scene", "versioned_id": "scene", "name": "Scene", "enabled": true,
   "settings": {"id_counter": 1, "custom_size": false, "items": [
     {"id": 1, "name": "Avatar", "visible": true, "align": 5, "bounds_type": 0, "rot": 0.0,
      "pos": {"x": 64.0, "y": 0.0}, "scale": {"x": 1.0, "y": 1.0}}]}}]}
JSON

display=:$((100 + RANDOM % 800))
Xvfb "$display" -screen 0 1280x900x24 >"$out/xvfb.log" 2>&1 &
processes=($!)
cleanup() { kill "${processes[@]}" 2>/dev/null || true; wait; }
trap cleanup EXIT
sleep 1
export DISPLAY=$display QT_QPA_PLATFORM=xcb XDG_RUNTIME_DIR=$out
obs --multi --collection CoSplat --profile CoSplat --scene Scene >"$out/obs.log" 2>&1 &
obs=$!
processes+=("$obs")
"$build/apps/cosplat" send "$head" --to "udp://127.0.0.1:$port" --loop --quiet &
processes+=($!)

fail() { echo "obs_studio.sh: $*" >&2; exit 1; }
memory() { awk '/^VmRSS/ { printf "%d", $2 / 1024 }' "/proc/$obs/status"; }
seconds=$(awk "BEGIN { print int(60 * $minutes) }")
start=$SECONDS first=0
while ((SECONDS - start < seconds)); do
  sleep 5
  kill -0 "$obs" 2>/dev/null || fail "OBS ended after $((SECONDS - start)) s, see $out/obs.log"
  if ((first == 0 && SECONDS - start >= seconds / 5)); then first=$(memory); fi
done
last=$(memory)
import -window root "$out/obs_1.png"
sleep 0.5
import -window root "$out/obs_2.png"
moved=$(compare -metric AE "$out/obs_1.png" "$out/obs_2.png" null: 2>&1 || true)
# The source's own background, green, and the face before it.
green=$(convert "$out/obs_1.png" -fuzz 2% -fill white +opaque '#00ff00' -fill black -opaque '#00ff00' \
  -format '%[fx:int(w*h*(1-mean))]' info:)
echo "OBS $(obs --version 2>/dev/null | tail -1 | sed 's/^OBS Studio - //'): $minutes minutes, memory $first MB after a" \
  "fifth of them, $last MB at the end"
echo "green pixels of the background: $green; pixels that changed in half a second: $moved"
grep -iE "cosplat" "$out/obs.log" || true
if grep -iE "cosplat.*(error|failed|cannot)" "$out/obs.log"; then fail "the log has errors"; fi
((green > 20000)) || fail "the source's background is not on the screen, see $out/obs_1.png"
((${moved%%.*} > 50)) || fail "the face does not move, see $out/obs_1.png and obs_2.png"
