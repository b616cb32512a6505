#!/usr/bin/env bash
# demo.sh BIN CONTENT OUT: makes the demo characters, cooks them and renders them; says how long each step took.
set -euo pipefail

bin=$1 content=$2 out=$3
mkdir -p "$content" "$out"

step() {
  local name=$1 begin end
  shift
  begin=$(date +%s%N)
  "$@" || { echo "demo: $name failed: $*" >&2; exit 1; }
  end=$(date +%s%N)
  printf 'demo: %-24s %6d ms\n' "$name" $(((end - begin) / 1000000))
}

step "make the content" "$bin/furrow_content" "$content"
for model in face sleeve; do
  step "cook $model" "$bin/furrow" cook "$content/$model.glb" --recipe "$content/$model.json" -o "$out/$model.furrow"
done
for model in face sleeve; do
  for view in beauty weight; do
    step "render $model, $view" "$bin/furrow" render "$out/$model.furrow" --view "$view" -o "$out/$model-$view.png"
  done
done
echo "demo: pictures in $out"
