extends Case
# Meshes of several surfaces, of which some are glass: a wall with a window, houses with automatic levels, a box with an outline.

var front: MeshInstance3D
var behind_glass: Array = []

func build() -> void:
	ground()
	var wall_and_window := ArrayMesh.new()
	add_box(wall_and_window, Vector3(-5, 3, 0), Vector3(10, 6, 0.5), plain(Color.SANDY_BROWN))
	add_box(wall_and_window, Vector3(4, 3, 0), Vector3(8, 6, 0.2), glass())
	front = draw(wall_and_window, Vector3(0, 0, -10))
	for x in range(-9, 9, 2):
		for z in [-13, -15]:
			var thing := wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
			if x > 1:
				behind_glass.append(thing)
	# Two bodies of other sizes grow coarser at other distances.
	var importer := ImporterMesh.new()
	for part in [[Vector3(0, 2, 0), 5.0, 12.0], [Vector3(0, 9, 0), 3.0, 9.0], [Vector3(6, 3, 0), 2.5, 6.0]]:
		var body := CapsuleMesh.new()
		body.radius = part[1]
		body.height = part[2]
		var material := glass() if importer.get_surface_count() == 2 else plain(Color.STEEL_BLUE)
		importer.add_surface(Mesh.PRIMITIVE_TRIANGLES, moved(body.get_mesh_arrays(), part[0]), [], {}, material)
	importer.generate_lods(60, 25, [])
	for x in [-9, 9]:
		draw(importer.get_mesh(), Vector3(x, 0, -30))
	for x in range(-14, 15, 2):
		for z in [-42, -46]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 15.0, 0.6, 0.9))
			wall(Vector3(x, 8, z), Vector3.ONE, Color.from_hsv(absf(x) / 15.0, 0.9, 0.6))
	# Its box lies behind the wall; its outline does not.
	var outlined := wall(Vector3(-8, 5.2, -12), Vector3.ONE)
	var outline := plain(Color.RED)
	outline.cull_mode = BaseMaterial3D.CULL_FRONT
	outline.grow = true
	outline.grow_amount = 1.5
	outlined.material_override.next_pass = outline
	sun()
	camera(Vector3(0, 1.7, 2))

func plain(colour: Color) -> StandardMaterial3D:
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	return material

func glass() -> StandardMaterial3D:
	var material := plain(Color(0.5, 0.8, 1.0, 0.3))
	material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
	return material

func draw(what: Mesh, at: Vector3) -> MeshInstance3D:
	var node := MeshInstance3D.new()
	node.mesh = what
	node.position = at
	add_child(node)
	return node

func add_box(to: ArrayMesh, at: Vector3, size: Vector3, material: Material) -> void:
	var box := BoxMesh.new()
	box.size = size
	to.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, moved(box.get_mesh_arrays(), at))
	to.surface_set_material(to.get_surface_count() - 1, material)

func moved(arrays: Array, by: Vector3) -> Array:
	arrays[Mesh.ARRAY_VERTEX] = Transform3D(Basis(), by) * (arrays[Mesh.ARRAY_VERTEX] as PackedVector3Array)
	return arrays

func steps() -> int:
	return 12

# Occluders come from another thread: some seconds may pass before the first.
func step(i: int) -> void:
	if i == 0:
		for k in 1200:
			if world.statistics().waiting == 0 and k > 2:
				break
			OS.delay_msec(20)
			world.cull_now()
	match i:
		2:
			front.set_surface_override_material(1, plain(Color.GREEN))
		3:
			front.set_surface_override_material(1, null)
		4:
			front.mesh.surface_get_material(0).transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
			front.mesh.surface_get_material(0).albedo_color.a = 0.5
		5:
			front.mesh.surface_get_material(0).transparency = BaseMaterial3D.TRANSPARENCY_DISABLED
		6:
			front.mesh.surface_set_material(0, glass())
			front.mesh.surface_set_material(1, plain(Color.SANDY_BROWN))
	cameras[0].position = Vector3(0.4 * i, 1.7, 2)
	if i > 6:
		front.visible = false
		cameras[0].position = Vector3(3.0 * sin(i), 1.7, 9.0 * (i - 6) * (i - 6) - 8)

func victims_of_glass() -> Array:
	return behind_glass

func most_drawn() -> float:
	return 0.85
