#!/bin/sh
# archive.sh GODOT ARCHIVE FOLDER: unpacks a release archive into an empty project in FOLDER, and checks without a screen that its
# node culls there and that the library has the text of Godot's help.
set -eu
godot=$1 archive=$2 work=$3
rm -rf "$work"
mkdir -p "$work/.godot"
unzip -q "$archive" -d "$work"
for file in README.md LICENSE.md icon.svg cullet.gdextension plugin.cfg plugin.gd dock.gd map.gd; do
    test -s "$work/addons/cullet/$file" || { echo "$archive lacks addons/cullet/$file"; exit 1; }
done
cd "$work"
printf 'config_version=5\n\n[application]\n\nconfig/name="Empty"\n' > project.godot
# See run.sh: Godot aborts where it finds an extension for the first time.
echo "res://addons/cullet/cullet.gdextension" > .godot/extension_list.cfg
cat > check.gd << 'END'
extends SceneTree

func _initialize() -> void:
	run.call_deferred()

func box(at: Vector3, size: Vector3) -> void:
	var node := MeshInstance3D.new()
	node.mesh = BoxMesh.new()
	node.transform = Transform3D(Basis.from_scale(size), at)
	root.add_child(node)

func run() -> void:
	box(Vector3(0, 0, -5), Vector3(20, 20, 1))
	for i in 5:
		box(Vector3(i - 2, 0, -9), Vector3.ONE * 0.5)
	var camera := Camera3D.new()
	root.add_child(camera)
	camera.make_current()
	var world: Node = ClassDB.instantiate("CulletWorld")
	root.add_child(world)
	await process_frame
	world.cull_now()
	var numbers: Dictionary = world.statistics()
	print(numbers)
	quit(0 if numbers.instances == 6 and numbers.visible == 1 else 1)
END
timeout 120 "$godot" --headless --path . --import > import.log 2>&1 || { cat import.log; exit 1; }
timeout 60 "$godot" --headless --path . --script res://check.gd > check.log 2>&1 || { cat check.log; exit 1; }
# Godot's own help is read from the library by the editor alone; `--doctool` writes empty pages.
for words in "Hides, in each frame, what no camera" "Counts and times, in microseconds" "came into the sight of a camera" \
    "Says in plain English why"; do
    grep -q "$words" addons/cullet/bin/libcullet_godot.so || { echo "the library has no help: $words"; exit 1; }
done
echo "ok: $archive works in an empty project"
