#!/bin/sh
# The main job on the shipped samples: look the maps over, then carve them. Usage: sh samples/demo.sh FOLDER
set -eu
samples=$(dirname "$0")
gallery=${1:-gallery}
mkdir -p "$gallery"

echo "== looking the maps over"
for map in medal_original medal_detail shell leaf_on_roll; do
    nmap inspect "$samples/$map.png"
done

echo "== detail-preserving: original and detail, 2 mm high"
nmap relief "$samples/medal_original.png" --detail "$samples/medal_detail.png" --mu 0.5 --height 2mm --width 40mm \
    -o "$gallery/medal.stl" -o "$gallery/medal.exr" --preview "$gallery/medal.png" --report "$gallery/medal.json" --overwrite

echo "== structure-preserving: the base alone"
nmap relief "$samples/medal_base.png" --height 2mm --width 40mm \
    -o "$gallery/medal_base.stl" --preview "$gallery/medal_base.png" --overwrite

echo "== a map on white, as a plaque and cut out"
nmap relief "$samples/shell.png" --height 4mm --width 50mm \
    -o "$gallery/shell.stl" -o "$gallery/shell_height.png" --preview "$gallery/shell.png" --overwrite
nmap relief "$samples/shell.png" --background cut --height 4mm --width 50mm \
    -o "$gallery/shell_cut.glb" --preview "$gallery/shell_cut.png" --overwrite

echo "== a leaf on a rolled background"
nmap relief "$samples/leaf_on_roll.png" --mask "$samples/leaf_mask.png" --background surface --surface "$samples/roll.png" \
    --width 60mm --height 3mm -o "$gallery/leaf.stl" --preview "$gallery/leaf.png" --overwrite

echo "== done: open the previews and meshes in $(cd "$gallery" && pwd)"
