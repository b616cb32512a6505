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
for model in face sleeve; do
  step "cook $model" "$bin/furrow" cook "$content/$model.glb" --recipe "$content/$model.json" -o "$content/$model.furrow" --quiet
done

model=face
extreme=(--morph browInnerUp=1 --morph browOuterUpLeft=0.8 --morph browOuterUpRight=0.8 --morph eyeSquintLeft=0.8 --morph eyeSquintRight=0.8
  --morph mouthSmileLeft=1 --morph mouthSmileRight=1)
camera=(--yaw 18 --zoom 1.7 --target 0 -0.025 -0.03)
picture face-neutral-plain "face, neutral, no wrinkles" --shading none "${camera[@]}"
picture face-neutral "face, neutral, wrinkles" "${camera[@]}"
picture face-extreme-plain "face, extreme, no wrinkles" --shading none "${camera[@]}" "${extreme[@]}"
picture face-extreme "face, extreme, wrinkles" "${camera[@]}" "${extreme[@]}"
picture face-extreme-weight "face, extreme, weight of forehead" --view weight --layer forehead "${camera[@]}" "${extreme[@]}"

model=sleeve
camera=(--yaw -25 --pitch 12)
extreme=(--clip bend --time 0.62)
picture sleeve-neutral-plain "sleeve, neutral, no wrinkles" --shading none "${camera[@]}"
picture sleeve-neutral "sleeve, neutral, wrinkles" "${camera[@]}"
picture sleeve-extreme-plain "sleeve, bent, no wrinkles" --shading none "${camera[@]}" "${extreme[@]}"
picture sleeve-extreme "sleeve, bent, wrinkles" "${camera[@]}" "${extreme[@]}"
picture sleeve-extreme-weight "sleeve, bent, weight of elbow" --view weight --layer elbow "${camera[@]}" "${extreme[@]}"

step "contact sheet" "$bin/furrow_contact_sheet" "$out/contact_sheet.png" 5 "furrow: dynamic wrinkles" "${cells[@]}"
echo "demo: pictures in $out, all of them on $out/contact_sheet.png"
