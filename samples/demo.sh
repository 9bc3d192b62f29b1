#!/bin/sh
# Makes maps of the sample meshes and reliefs of all samples. Usage: sh samples/demo.sh FOLDER
set -eu
samples=$(dirname "$0")
gallery=${1:-gallery}
mkdir -p "$gallery"

echo "== original, base and detail maps of three meshes, and their reliefs"
for mesh in portrait vase rings; do
    nmap bake "$samples/$mesh.ply" -o "$gallery/$mesh" --shading smooth --sigma-s 2 --plot "$gallery/${mesh}_plot.png" --overwrite
    nmap relief "$gallery/$mesh/original.exr" --detail "$gallery/$mesh/detail.exr" --mu 0.5 --height 4mm \
        -o "$gallery/$mesh.stl" --preview "$gallery/$mesh.png" --report "$gallery/$mesh.json" --overwrite
done

echo "== the same without parameters: a filter trained on many meshes"
nmap bake "$samples/vase.ply" -o "$gallery/vase_learned" --shading smooth --filter learned --overwrite
nmap relief "$gallery/vase_learned/base.exr" --height 4mm \
    -o "$gallery/vase_learned.stl" --preview "$gallery/vase_learned.png" --overwrite

echo "== the structure alone: the base map"
nmap relief "$gallery/portrait/base.exr" --height 4mm \
    -o "$gallery/portrait_base.stl" --preview "$gallery/portrait_base.png" --overwrite

echo "== the portrait without its detail, and with 1.4 times as much"
nmap smooth "$samples/portrait.ply" -o "$gallery/portrait_smooth.stl" --sigma-s 1.5 --report "$gallery/portrait_smooth.json" --overwrite
nmap smooth "$samples/portrait.ply" -o "$gallery/portrait_crisp.stl" --sigma-s 1.5 --detail-gain 1.4 --overwrite
nmap bake "$gallery/portrait_crisp.stl" -o "$gallery/portrait_crisp" --shading smooth --sigma-s 2 --overwrite
nmap relief "$gallery/portrait_crisp/original.exr" --height 4mm \
    -o "$gallery/portrait_crisp_relief.stl" --preview "$gallery/portrait_crisp.png" --overwrite

echo "== maps without a mesh: inspect them, split one into base and detail"
for map in medal_original medal_detail shell leaf_on_roll; do
    nmap inspect "$samples/$map.png"
done
nmap compose split "$samples/shell.png" -o "$gallery/shell_layers" --format png --overwrite
nmap relief "$samples/shell.png" --detail "$gallery/shell_layers/detail.png" --mu 1 --height 4mm --width 50mm \
    -o "$gallery/shell.stl" -o "$gallery/shell_height.png" --preview "$gallery/shell.png" --overwrite

echo "== a medal from its layers, 2 mm high"
nmap relief "$samples/medal_original.png" --detail "$samples/medal_detail.png" --mu 0.5 --height 2mm --width 40mm \
    -o "$gallery/medal.stl" -o "$gallery/medal.exr" --preview "$gallery/medal.png" --overwrite

echo "== the shell cut out"
nmap relief "$samples/shell.png" --background cut --height 4mm --width 50mm \
    -o "$gallery/shell_cut.glb" --preview "$gallery/shell_cut.png" --overwrite

echo "== a leaf on a rolled background"
nmap relief "$samples/leaf_on_roll.png" --mask "$samples/leaf_mask.png" --background surface --surface "$samples/roll.png" \
    --width 60mm --height 3mm -o "$gallery/leaf.stl" --preview "$gallery/leaf.png" --overwrite

echo "== composed maps: a recipe of a medal and a shell; a mirrored head and a rotated vase on one plate"
nmap compose stack "$samples/scene.toml" -o "$gallery/scene.exr" --curl "$gallery/scene_curl.png" --overwrite
nmap relief "$gallery/scene.exr" --height 3mm -o "$gallery/scene.stl" --preview "$gallery/scene.png" --overwrite
nmap compose transform "$gallery/portrait/original.exr" -o "$gallery/mirrored.exr" --flip-h --pad 40%,0,0,0 --overwrite
nmap compose paste "$gallery/mirrored.exr" "$gallery/vase/original.exr" -o "$gallery/pair.exr" \
    --scale 0.8 --at 19%,55% --rotate -10 --overwrite
nmap relief "$gallery/pair.exr" --height 5mm -o "$gallery/pair.stl" --preview "$gallery/pair.png" --overwrite

echo "== solids: a pendant cut out of the medal, a hollow plaque, a portrait on its plate, a town gate with upright walls"
nmap relief "$samples/medal_original.png" --detail "$samples/medal_detail.png" --mu 0.5 --background cut --height 2mm --width 40mm \
    --base 1.5mm -o "$gallery/pendant.3mf" -o "$gallery/pendant.stl" --overwrite
nmap relief "$samples/leaf_on_roll.png" --mask "$samples/leaf_mask.png" --background surface --surface "$samples/roll.png" \
    --width 60mm --height 3mm --base 4mm --hollow 1.2mm -o "$gallery/plaque.stl" --overwrite
nmap relief "$gallery/portrait/original.exr" --detail "$gallery/portrait/detail.exr" --mu 0.5 --height 4mm \
    --base 3mm --max-error 0.01mm -o "$gallery/portrait_plate.3mf" --overwrite
nmap bake "$samples/gate.ply" -o "$gallery/gate" --overwrite
nmap relief "$gallery/gate/original.exr" --edge auto --height 4mm --base 3mm --triangles 100k \
    -o "$gallery/gate.3mf" -o "$gallery/gate.stl" --preview "$gallery/gate.png" --overwrite

echo "== plates: a coin with a legend and a rope, an oval cameo, a pendant with a loop, a plaque with a text"
cp "$samples/coin.toml" "$gallery/coin.toml"
nmap relief "$gallery/coin.toml" -o "$gallery/coin.stl" -o "$gallery/coin.3mf" --overwrite
nmap relief "$gallery/portrait/original.exr" --detail "$gallery/portrait/detail.exr" --preset cameo --width 40mm \
    --max-error 0.005mm -o "$gallery/cameo.stl" --save-recipe "$gallery/cameo.toml" --overwrite
nmap relief "$samples/shell.png" --preset pendant --width 28mm --max-error 0.004mm -o "$gallery/shell_pendant.stl" --overwrite
nmap relief "$gallery/vase/original.exr" --detail "$gallery/vase/detail.exr" --preset plaque --width 70mm \
    --text "Vasa antiqua" --text-size 4mm --max-error 0.01mm -o "$gallery/vase_plaque.stl" --overwrite

echo "== their pictures in gold, marble, bronze and walnut, and a section of the coin"
nmap preview "$gallery/coin.stl" --material gold -o "$gallery/coin_gold.png" --overwrite
nmap preview "$gallery/cameo.stl" --material marble -o "$gallery/cameo_marble.png" --overwrite
nmap preview "$gallery/shell_pendant.stl" --material bronze -o "$gallery/pendant_bronze.png" --overwrite
nmap preview "$gallery/vase_plaque.stl" --material walnut -o "$gallery/plaque_walnut.png" --overwrite
nmap preview "$gallery/coin.stl" --view iso --material silver -o "$gallery/coin_iso.png" --overwrite
nmap preview "$gallery/coin.stl" --section y=50% -o "$gallery/coin_section.png" --overwrite

echo "== done: open the previews, contact sheets (sheet.png) and meshes in $(cd "$gallery" && pwd)"
