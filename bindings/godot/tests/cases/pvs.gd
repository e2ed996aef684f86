extends Case
# Rooms with baked visibility: walks through them, then a wall goes, one turns to glass, one moves, a thing moves, another comes.

const COUNT := 5

var root: Node3D

func build() -> void:
	root = Rooms.build(self, COUNT, 12)
	sun()
	camera(Vector3(-4, 1.6, 1))

func begin() -> void:
	# Occlusion would find the same, and more.
	world.occlusion = false
	world.pvs = [await Rooms.bake(world, root)]

func steps() -> int:
	return 30

func step(i: int) -> void:
	var cam := cameras[0]
	cam.position = Vector3(-15.6 + 8.0 * (i % 4), 1.6, -11.0 + 8.0 * ((i / 4) % 4))
	cam.look_at(Vector3(0, 1.6, 0))
	cam.rotation.y += 0.8 * sin(i * 2.0)
	if i >= 25:
		# Each wall of the room goes: what was hidden behind it is seen.
		for node: Node3D in root.get_children():
			if node.name.left(1) in ["a", "b"] and node.position.distance_to(cam.position) < 9.0:
				node.visible = false
	var ahead := cam.position - cam.basis.z * 2.0
	match i:
		# In a doorway, in a wall, and outside.
		16:
			cam.position = Vector3(-4.0, 1.6, -5.0)
		17:
			cam.position = Vector3(-4.05, 1.6, -2.0)
		18:
			cam.position = Vector3(40, 20, 40)
			cam.look_at(Vector3.ZERO)
		# Nodes that hide nothing in the sets move, come and go.
		20:
			root.get_node("t2_2_0").position = ahead
		21:
			Rooms.box(root, "late", ahead, Vector3.ONE * 0.4, Color.RED)
		22:
			root.get_node("t2_2_1").free()
		# Walls go, turn to glass, move and are hidden.
		23:
			root.get_node("b2_2_0").queue_free()
		24:
			var material: StandardMaterial3D = root.get_node("b3_2_0").material_override
			material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
			material.albedo_color.a = 0.2
		26:
			root.get_node("b1_1_0").position.y += 2.0
		28:
			root.get_node("a3_3_1").visible = false

func most_drawn() -> float:
	return 0.47

# What a set that lost a node would hide: a thing in the room of the camera.
func victims_of_lost_node() -> Array:
	var at := cameras[0].global_position
	var seen := world.pvs[0].seen_from(at)
	var nodes := Array(seen).map(func(path): return root.get_node_or_null(path)).filter(func(n): return n != null and n.is_in_group("thing"))
	nodes.sort_custom(func(a, b): return a.global_position.distance_to(at) < b.global_position.distance_to(at))
	return nodes.slice(0, 3)
