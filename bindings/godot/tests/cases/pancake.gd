extends "res://cases/changes.gd"
# The same changes under a sun whose maps are not flattened: what is hidden from it casts nothing of its own.

func build() -> void:
	super()
	for child in get_children():
		if child is DirectionalLight3D:
			child.directional_shadow_pancake_size = 0.0
