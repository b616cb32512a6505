#!/usr/bin/env bash
# figures.sh BIN CONTENT OUT: makes the figures of docs/figures.md. Needs gnuplot and OpenGL 4.3.
set -euo pipefail

bin=$1 content=$2 out=$3
tools=$(dirname "$0")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$content" "$out"

"$bin/furrow_content" "$content"
for model in face jacket; do
  "$bin/furrow" cook "$content/$model.glb" --recipe "$content/$model.json" -o "$content/$model.furrow" --quiet
done
"$bin/furrow_figures" "$scratch"
mv "$scratch/seam.png" "$out/seam.png"
gnuplot -e "data='$scratch'; out='$out'" "$tools/plots.gp"

face=(--morph browInnerUp=1 --morph browOuterUpLeft=0.8 --morph browOuterUpRight=0.8 --yaw 18 --zoom 3.4 --target 0.01 0.025 0.03)
jacket=(--clip lean --time 1 --yaw 24 --zoom 2 --target 0 -0.15 0)
cells=()

# picture MODEL CAPTION OPTION...: adds a picture to the sheet.
picture() {
  local model=$1 caption=$2 file=$scratch/${#cells[@]}.png
  local -n pose=$model
  shift 2
  "$bin/furrow" render "$content/$model.furrow" --size 330x330 -o "$file" "${pose[@]}" "$@"
  cells+=("$file=$caption")
}

# sheet NAME COLUMNS TITLE: writes the pictures since the last sheet.
sheet() {
  "$bin/furrow_contact_sheet" "$out/$1.png" "$2" "$3" "${cells[@]}"
  cells=()
}

for model in face jacket; do
  picture "$model" "no wrinkles" --shading none
  picture "$model" "alpha shading" --shading alpha
  picture "$model" "bump-map blending" --shading blend
  picture "$model" "interpolated bump mapping" --shading interpolated
done
sheet methods 4 "Larsson's three methods"

for model in face jacket; do
  picture "$model" "gpu: OpenGL 4.3, compute" --backend gpu
  picture "$model" "gpu-raster: OpenGL 3.3" --backend gpu-raster
  picture "$model" "cpu, drawn by OpenGL" --backend cpu --shading interpolated
  picture "$model" "cpu, drawn in software" --backend cpu
done
sheet tiers 4 "The tiers"
