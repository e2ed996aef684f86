extends Case
# Parents that move, turn over and are hidden; nodes that change their parents; flat and mirrored ones.

var parents: Array[Node3D] = []
var front: MeshInstance3D

func build() -> void:
	ground()
	for i in 3:
		var parent := Node3D.new()
		add_child(parent)
		parents.append(parent)
	front = wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	front.reparent(parents[0])
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9)).reparent(parents[1 + (x & 2) / 2])
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 14

func most_drawn() -> float:
	return 0.8

var late: Array = []

# What a culler would hide that heard of the movement a frame late.
func victims_of_late_movers() -> Array:
	return late

func step(i: int) -> void:
	late = []
	match i:
		1:
			parents[1].position.y += 6
			late = parents[1].get_children()
		2:
			parents[0].visible = false
		3:
			parents[0].visible = true
			parents[1].position.y -= 6
		4:
			parents[0].scale.x = -1
		5:
			parents[0].scale.x = 0.3
		6:
			parents[0].scale = Vector3.ONE
			front.reparent(parents[2])
		7:
			parents[2].rotation.y = 0.6
		8:
			remove_child(parents[1])
		9:
			add_child(parents[1])
			parents[1].position.y = 5
		10:
			front.top_level = true
			front.position = Vector3(0, 3, -30)
		11:
			parents[1].scale = Vector3(1, 0, 1)
		12:
			var copy := parents[1].duplicate()
			copy.scale = Vector3.ONE
			copy.position = Vector3(0, 2, 3)
			add_child(copy)
		13:
			parents[2].free()
