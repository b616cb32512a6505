#!/usr/bin/env bash
# gallery.sh BIN CONTENT OUT CONTACT_SHEET: the sheets of docs/gallery.md, from the assets that demo.sh has cooked into CONTENT, and its
# contact sheet at half its size; all with 256 colours, a third of the bytes.
set -euo pipefail

bin=$1 content=$2 out=$3 contact_sheet=$4
mkdir -p "$out"
cells=()

# picture CAPTION OPTION...: one picture of $model from $camera.
picture() {
  local caption=$1 file=$out/cell_${#cells[@]}.png
  shift
  "$bin/furrow" render "$content/$model.furrow" --size 256x256 -o "$file" "${camera[@]}" "$@"
  cells+=("$file=$caption")
}

# pose CAPTION NAME=W ...: a picture with morph targets.
pose() {
  local caption=$1 morph morphs=()
  shift
  for morph in "$@"; do morphs+=(--morph "$morph"); done
  picture "$caption" "${morphs[@]}"
}

# reduced FROM TO: with 256 colours.
reduced() {
  pngquant --force --strip --output "$2" 256 "$1"
}

# sheet NAME COLUMNS TITLE: what has been drawn since the last one.
sheet() {
  "$bin/furrow_contact_sheet" "$out/$1.png" "$2" "$3" "${cells[@]}"
  rm -f "$out"/cell_*.png
  reduced "$out/$1.png" "$out/$1.png"
  cells=()
}

both() { # a side, NAME=W of both sides
  echo "${1%=*}Left=${1#*=} ${1%=*}Right=${1#*=}"
}

model=face
camera=(--yaw 16 --zoom 1.9 --target 0.004 -0.022 0)
pose "neutral"
pose "brows raised" browInnerUp=1 $(both browOuterUp=0.8)
pose "frown" $(both browDown=1)
pose "squint" $(both eyeSquint=1) $(both cheekSquint=1)
pose "smile" $(both mouthSmile=1) $(both cheekSquint=0.6)
pose "sneer" $(both noseSneer=1) $(both mouthUpperUp=0.4)
pose "jaw open" jawOpen=1
pose "blink" $(both eyeBlink=1)
pose "eyes wide" $(both eyeWide=1) browInnerUp=0.4
pose "corners down" $(both mouthFrown=1) mouthShrugLower=0.8 browInnerUp=0.5
pose "pucker" mouthPucker=1
pose "funnel" mouthFunnel=1
pose "teeth" $(both mouthUpperUp=1) $(both mouthLowerDown=1)
pose "stretch" $(both mouthStretch=1)
pose "wink and half a smile" eyeBlinkLeft=1 cheekSquintLeft=1 mouthSmileLeft=0.9 browOuterUpRight=0.7
sheet gallery_face 5 "Expressions of the demo face"

details() {
  camera=(--yaw 14 --zoom 3.4 --target 0.008 0.045 0.02)
  picture "forehead$2" --shading "$1" --morph browInnerUp=1 --morph browOuterUpLeft=0.8 --morph browOuterUpRight=0.8
  camera=(--yaw 14 --zoom 5 --target 0.004 0.024 0.02)
  picture "glabella$2" --shading "$1" --morph browDownLeft=1 --morph browDownRight=1
  camera=(--yaw 50 --zoom 5 --target 0.05 0.002 0)
  picture "crow's feet$2" --shading "$1" --morph eyeSquintLeft=1 --morph cheekSquintLeft=1
  camera=(--yaw 20 --zoom 5 --target 0.008 -0.012 0.03)
  picture "bunny lines$2" --shading "$1" --morph noseSneerLeft=1 --morph noseSneerRight=1
  camera=(--yaw 32 --zoom 3.8 --target 0.02 -0.055 0.01)
  picture "nasolabial fold$2" --shading "$1" --morph mouthSmileLeft=1 --morph mouthSmileRight=1
  picture "jaw open, too$2" --shading "$1" --morph mouthSmileLeft=0.6 --morph mouthSmileRight=0.6 --morph jawOpen=1
  camera=(--yaw 12 --pitch -15 --zoom 3.6 --target 0 -0.115 0)
  picture "cords of the neck$2" --shading "$1" --morph mouthStretchLeft=1 --morph mouthStretchRight=1
}
details none ", without"
details interpolated ""
sheet gallery_details 7 "Layers of the demo face, without and with wrinkles"

model=jacket
motions() {
  camera=(--yaw 24 --zoom 1.5 --target 0 -0.1 0)
  picture "at rest$2" --shading "$1"
  picture "lean$2" --shading "$1" --clip lean --time 1
  picture "twist$2" --shading "$1" --clip twist --time 0.75
  camera=(--yaw 20 --zoom 2 --target 0.1 0 0)
  picture "arms raised$2" --shading "$1" --clip raise --time 0.9
  camera=(--yaw 32 --pitch 22 --zoom 2.4 --target -0.34 -0.06 0.06)
  picture "elbows bent$2" --shading "$1" --clip bend --time 1
}
motions none ", without"
motions interpolated ""
sheet gallery_jacket 5 "Jacket, without and with wrinkles"

model=panel
camera=(--yaw 14 --zoom 0.9)
for shading in none interpolated; do
  for morph in shear pinch squeeze; do
    picture "$morph$([[ $shading == none ]] && echo ", without")" --shading "$shading" --morph "$morph=1"
  done
done
sheet gallery_panel 3 "Panel, without and with wrinkles"

pngtopam "$contact_sheet" | pamscale -reduce 2 | pnmtopng > "$out/cell.png"
reduced "$out/cell.png" "$out/contact_sheet.png"
rm "$out/cell.png"
