#!/usr/bin/env bash
# demo.sh BIN CONTENT OUT: makes the demo characters, cooks them, renders them with and without wrinkles, and puts the pictures on one
# contact sheet; says how long each step took.
set -euo pipefail

bin=$1 content=$2 out=$3
mkdir -p "$content" "$out"
cells=()

step() {
  local name=$1 begin end
  shift
  begin=$(date +%s%N)
  "$@" || { echo "demo: $name failed: $*" >&2; exit 1; }
  end=$(date +%s%N)
  printf 'demo: %-34s %6d ms\n' "$name" $(((end - begin) / 1000000))
}

# picture NAME CAPTION OPTION...: renders one picture of $model and adds it to the sheet.
picture() {
  local name=$1 caption=$2
  shift 2
  step "render $name" "$bin/furrow" render "$content/$model.furrow" --size 640x640 -o "$out/$name.png" "$@"
  cells+=("$out/$name.png=$caption")
}

step "make the content" "$bin/furrow_content" "$content"
for model in face jacket sleeve panel; do
  step "cook $model" "$bin/furrow" cook "$content/$model.glb" --recipe "$content/$model.json" -o "$content/$model.furrow" --quiet
done

# five NAME CAPTION LAYER: neutral and posed as $pose, each without and with wrinkles, then the weight of a layer.
five() {
  local name=$1 caption=$2 layer=$3
  picture "$name-neutral-plain" "$caption, neutral, no wrinkles" --shading none "${camera[@]}"
  picture "$name-neutral" "$caption, neutral, wrinkles" "${camera[@]}"
  picture "$name-posed-plain" "$caption, posed, no wrinkles" --shading none "${camera[@]}" "${pose[@]}"
  picture "$name-posed" "$caption, posed, wrinkles" "${camera[@]}" "${pose[@]}"
  picture "$name-weight" "$caption, posed, weight of $layer" --view weight --layer "$layer" "${camera[@]}" "${pose[@]}"
}

# morphs NAME=W ...: sets $pose.
morphs() {
  pose=()
  local morph
  for morph in "$@"; do pose+=(--morph "$morph"); done
}

model=face
camera=(--yaw 18 --zoom 1.7 --target 0 -0.025 -0.03)
morphs browInnerUp=1 browOuterUpLeft=0.8 browOuterUpRight=0.8 eyeSquintLeft=0.5 eyeSquintRight=0.5 mouthSmileLeft=1 mouthSmileRight=1 \
  cheekSquintLeft=0.6 cheekSquintRight=0.6
five face "face" forehead
camera=(--yaw 24 --zoom 3.6 --target 0.012 0.005 0.02)
morphs browDownLeft=1 browDownRight=1 eyeSquintLeft=0.8 eyeSquintRight=0.8 noseSneerLeft=0.9 noseSneerRight=0.9
five eyes "eyes" glabella

model=jacket
camera=(--yaw 24 --zoom 1.55 --target 0 -0.1 0)
pose=(--clip lean --time 1)
five jacket "jacket" waist

model=sleeve
camera=(--yaw -25 --pitch 12)
pose=(--clip bend --time 0.62)
five sleeve "sleeve" elbow

model=panel
camera=(--yaw 14 --zoom 0.9)
morphs shear=1
five panel "panel" shear

# The editor, played by a script on a copy of the face; half as large as on a screen.
mkdir -p "$out/editor"
cp "$content/face.glb" "$content/face.json" "$out/editor"
step "play the editor" "$bin/furrow-editor" "$out/editor/face.glb" --script "$(dirname "$0")/../content/editor_session.txt" --frames "$out" --size 640x640 --scale 0.5
for shot in "open=editor: a face, opened" "play=editor: brows raised" "paint=editor: painting a rest bias" "split=editor: with and without" "uv=editor: UV layout"; do
  cells+=("$out/editor_${shot%%=*}.png=${shot#*=}")
done

step "contact sheet" "$bin/furrow_contact_sheet" "$out/contact_sheet.png" 5 "furrow: dynamic wrinkles" "${cells[@]}"
echo "demo: pictures in $out, all of them on $out/contact_sheet.png"
