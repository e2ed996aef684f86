class_name City
# A city of boxes: blocks of houses with streets between them, and small things on the pavements.

static func build(parent: Node, blocks: int, things: int, seed_ := 7) -> int:
	var rng := RandomNumberGenerator.new()
	rng.seed = seed_
	var box := BoxMesh.new()
	var materials: Array[StandardMaterial3D] = []
	for i in 12:
		var material := StandardMaterial3D.new()
		material.albedo_color = Color.from_hsv(i / 12.0, 0.35, 0.85)
		materials.append(material)
	var count := 0
	var pitch := 28.0
	for bx in blocks:
		for bz in blocks:
			var corner := Vector3((bx - blocks / 2) * pitch, 0, (bz - blocks / 2) * pitch)
			for i in 4:
				var h := rng.randf_range(8.0, 40.0)
				var at := corner + Vector3(5.0 + 10.0 * (i % 2), h * 0.5, 5.0 + 10.0 * (i / 2))
				add(parent, box, materials[rng.randi() % 12], at, Vector3(9.9, h, 9.9), "house")
				count += 1
			for i in things:
				var s := rng.randf_range(0.3, 1.2)
				var side := rng.randi() % 4
				var along := rng.randf_range(-1.5, 21.5)
				var across := -1.0 if side % 2 == 0 else 21.0
				var at := corner + (Vector3(along, s * 0.5, across) if side < 2 else Vector3(across, s * 0.5, along))
				add(parent, box, materials[rng.randi() % 12], at, Vector3(s, s, s), "thing")
				count += 1
	var ground := MeshInstance3D.new()
	ground.mesh = PlaneMesh.new()
	ground.mesh.size = Vector2(blocks, blocks) * pitch * 1.2
	parent.add_child(ground)
	return count + 1

static func add(parent: Node, mesh: Mesh, material: Material, at: Vector3, size: Vector3, group: String) -> MeshInstance3D:
	var node := MeshInstance3D.new()
	node.mesh = mesh
	node.material_override = material
	node.transform = Transform3D(Basis.from_scale(size), at)
	node.add_to_group(group)
	parent.add_child(node)
	return node

# Godot's own occluders: one for each house.
static func add_occluders(parent: Node) -> int:
	var count := 0
	for house in parent.get_tree().get_nodes_in_group("house"):
		var node := OccluderInstance3D.new()
		var shape := BoxOccluder3D.new()
		shape.size = house.transform.basis.get_scale()
		node.occluder = shape
		node.position = house.position
		parent.add_child(node)
		count += 1
	return count

# Walks along a street, looking about.
static func walk(camera: Camera3D, t: float) -> void:
	camera.position = Vector3(-4.0 + 1.5 * sin(t * 20.0), 1.7, lerpf(200.0, -200.0, t))
	camera.rotation = Vector3(0, 0.9 * sin(t * 12.0), 0)
