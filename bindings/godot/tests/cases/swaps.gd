extends Case
# Scenes that are swapped, and nodes that come and go within one frame.

var part: Node3D

func build() -> void:
	part = Node3D.new()
	add_child(part)
	City.build(part, 4, 6)
	sun(true)
	camera(Vector3(-4, 1.7, 30))

func step(i: int) -> void:
	part.free()
	part = Node3D.new()
	add_child(part)
	City.build(part, 4, 6, 20 + i)
	var fleeting := MeshInstance3D.new()
	fleeting.mesh = BoxMesh.new()
	add_child(fleeting)
	fleeting.free()
	var later := MeshInstance3D.new()
	later.mesh = BoxMesh.new()
	add_child(later)
	later.position = Vector3(-4, 2, 20)
	later.queue_free()
	var moved := MeshInstance3D.new()
	add_child(moved)
	remove_child(moved)
	moved.free()

func most_drawn() -> float:
	return 0.6
