extends Case
# Layers of cameras and nodes, and their changes.

var front: MeshInstance3D
var things: Array = []

func build() -> void:
	ground()
	front = wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			var thing := wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
			thing.layers = 1 << (things.size() % 3)
			things.append(thing)
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 8

func step(i: int) -> void:
	match i:
		1:
			front.layers = 4
			cameras[0].cull_mask = 3
		2:
			cameras[0].cull_mask = 7
		3:
			front.layers = 1
			cameras[0].cull_mask = 5
		4:
			things[16].layers = 1
			things[16].position.y = 8
		5:
			cameras[0].cull_mask = 1 << 19
		6:
			cameras[0].cull_mask = 0xfffff
			front.layers = 1 << 19
		7:
			front.layers = 0
